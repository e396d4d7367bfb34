-- Which frame is an echo, and which request a response answers (protocol.md D1, D13).
--
-- On a line with echo the first received frame that repeats a sent one is its echo; whether a line
-- echoes at all is decided by the availability request (01), whose response never repeats it. A
-- frame that is no echo answers the last request before it.

local SILENCE = 0.25 -- s; an unfinished frame is abandoned after it
local SILENCE_AFTER_SENDING = 0.02 -- s; the same, if a request was sent in between
local MOST_UNECHOED = 64
local AVAILABILITY = "\1"
local SENT, RECEIVED = 1, 2

-- A request: `body` (nil: not known, or damaged), `number` of its packet, `time`, and, once known,
-- `response`, the packet of the first one.
local UNKNOWN = {}

local Matching = {}
Matching.__index = Matching

local function new_matching()
  return setmetatable({ request = UNKNOWN, before = UNKNOWN, unechoed = {} }, Matching)
end

function Matching:answered()
  -- Before its echo, a frame can't be the response to the request that was just sent.
  return self.echoes and #self.unechoed > 0 and self.before or self.request
end

-- A part of the recording is missing, perhaps with a request in it. A stream continues.
function Matching:interrupt()
  local row = self.request.body and TABLES.commands[self.request.body:byte()]
  if not (row and row.stream) then
    self.request = UNKNOWN
  end
  self.before = UNKNOWN
end

function Matching:sent(event, packet)
  self.before = self.request
  self.request = { body = event.body, number = packet.number, time = packet.time }
  self.unechoed[#self.unechoed + 1] = { wire = event.wire, request = self.request }
  if #self.unechoed > MOST_UNECHOED then
    table.remove(self.unechoed, 1)
  end
  return self.request
end

-- Returns the request of which a received frame, or damage, is the echo; else nil.
function Matching:received(event)
  if not event.body then
    self.before = self.request -- the damage may have been the echo
  end
  local at
  for index, sent in ipairs(self.unechoed) do
    if sent.wire == event.wire then
      at = index
      break
    end
  end
  if self.request.body == AVAILABILITY and event.body and #event.body == 1 then
    if at then
      self.echoes = true
    elseif self.echoes == nil then
      self.echoes = false
    end
  end
  if self.echoes == false or not at then
    return nil
  end
  local request = self.unechoed[at].request
  for _ = 1, at do
    table.remove(self.unechoed, 1)
  end
  return request
end

-- One direction: a decoder, and the latest packets, by which of its bytes they brought.
local Direction = {}
Direction.__index = Direction

local function new_direction(way)
  return setmetatable(
    { way = way, decoder = new_decoder(), packets = {}, first = 1, last = 0 }, Direction)
end

function Direction:add(packet)
  packet.start = self.decoder.offset + #self.decoder.buffer
  packet.stop = packet.start + #packet.bytes
  self.last = self.last + 1
  self.packets[self.last] = packet
end

function Direction:drop_before(start)
  while self.first <= self.last and self.packets[self.first].stop <= start do
    self.packets[self.first] = nil
    self.first = self.first + 1
  end
end

-- Completes an event: its `way`, `first` and `last` number of the packets with its bytes, and `at`,
-- its place in the present packet if it lies in it whole. `completed` gets the number of every
-- other packet.
function Direction:locate(item, present, completed)
  self:drop_before(item.offset)
  item.way = self.way
  local stop, at = item.offset + #item.wire, self.first
  item.first = self.packets[at].number
  while self.packets[at].stop < stop do
    completed(self.packets[at].number, present.number)
    at = at + 1
  end
  item.last = self.packets[at].number
  if self.packets[at] ~= present then
    completed(item.last, present.number)
  end
  if present.start and item.offset >= present.start then
    item.at = item.offset - present.start
  end
  return item
end

-- Returns the unfinished frame as damage, or nil.
function Direction:unfinished(present, completed)
  local left = self.decoder.buffer
  if left == "" then
    return nil
  end
  local item = { reason = "unfinished", wire = left, offset = self.decoder.offset }
  self:locate(item, present, completed)
  if left:sub(-1) == "\r" then -- the decoder was waiting for a raw checksum 0D (D3)
    item.wire, item.reason = left:sub(1, -2), "checksum"
  end
  return item
end

-- One port of one recording. `completed(number, by)`: the bytes of a packet belong to a frame that
-- another packet completes.
local Port = {}
Port.__index = Port

local function new_port(completed)
  return setmetatable({
    matching = new_matching(), following = new_following(), completed = completed,
    directions = { [SENT] = new_direction(SENT), [RECEIVED] = new_direction(RECEIVED) },
    sent_last = false,
  }, Port)
end

function Port:is_late(direction, packet, way)
  if not direction.last_time then
    return false
  end
  local silence = packet.time - #packet.bytes * byte_time() - direction.last_time
  local answered = way == RECEIVED and self.sent_last
  return silence > (answered and SILENCE_AFTER_SENDING or SILENCE)
end

-- Returns the frames and the damage that a packet (`number`, `time`, `bytes`) completes. Each has
-- what the decoder and `locate` give it, and `sent`, `echo_of` or `answers`: a request.
function Port:feed(way, packet)
  local direction, matching, items = self.directions[way], self.matching, {}
  if self:is_late(direction, packet, way) then
    items[1] = direction:unfinished(packet, self.completed)
    direction.decoder:reset()
  end
  if way == SENT and not self.sent_last then
    matching.unechoed = {} -- missing echoes will not follow any more
  end
  direction.last_time = packet.time
  if packet.bytes ~= "" then
    direction:add(packet)
    for _, item in ipairs(direction.decoder:feed(packet.bytes)) do
      direction:locate(item, packet, self.completed)
      if way == SENT then
        item.sent = matching:sent(item, packet)
      else
        item.echo_of = matching:received(item)
        item.answers = not item.echo_of and matching:answered() or nil
      end
      items[#items + 1] = item
    end
    direction:drop_before(direction.decoder.offset)
  end
  self.sent_last = way == SENT
  return items
end
