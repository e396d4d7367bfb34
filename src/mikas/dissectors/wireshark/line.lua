-- The line packet by packet: which frames and damage each packet completes, and what they are.

local SILENCE = 0.25 -- s; an unfinished frame is abandoned after it
local SILENCE_AFTER_SENDING = 0.02 -- s; the same, if a request was sent in between
local SENT, RECEIVED = 1, 2

-- One direction: a decoder, and the latest packets, by which of its bytes they brought.
local Direction = {}
Direction.__index = Direction

local function new_direction(way)
  return setmetatable(
    { way = way, decoder = new_decoder(), packets = {}, first = 1, last = 0 }, Direction)
end

-- Takes a packet (`number`, `time`) with these bytes.
function Direction:add(packet, bytes)
  packet.start = self.decoder.offset + #self.decoder.buffer
  packet.stop = packet.start + #bytes
  local solid = #bytes
  while bytes:byte(solid) == TERMINATOR do
    solid = solid - 1
  end
  packet.solid = packet.start + solid -- only bare terminators are behind it
  self.decoder:add(bytes)
  self.last = self.last + 1
  self.packets[self.last] = packet
end

function Direction:drop_before(start)
  while self.first <= self.last and self.packets[self.first].stop <= start do
    self.packets[self.first] = nil
    self.first = self.first + 1
  end
end

-- Completes an event: its `way`, `first` and `last` number of the packets with its bytes, `began`
-- and `ended`, their times, `wire_time`, when its first byte began on the wire, whether more
-- `followed` in the last one, and `at`, its place in the present packet if it lies in it whole. `completed` gets the number of every other packet.
function Direction:locate(item, present, completed)
  self:drop_before(item.offset)
  item.way = self.way
  local stop, at = item.offset + #item.wire, self.first
  item.first, item.began = self.packets[at].number, self.packets[at].time
  item.wire_time = item.began
  while true do
    local packet = self.packets[at]
    local implied = packet.time - (packet.stop - item.offset) * byte_time()
    item.wire_time = math.min(item.wire_time, implied)
    if packet.stop >= stop then
      break
    end
    completed(packet.number, present.number)
    at = at + 1
  end
  local last = self.packets[at]
  item.last, item.ended = last.number, last.time
  if last ~= present then
    completed(item.last, present.number)
  elseif item.offset >= present.start then
    item.at = item.offset - present.start
  end
  item.followed = stop < last.solid
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

function Port:is_late(direction, time, length, way)
  if not direction.last_time then
    return false
  end
  local silence = time - length * byte_time() - direction.last_time
  local answered = way == RECEIVED and self.sent_last
  return silence > (answered and SILENCE_AFTER_SENDING or SILENCE)
end

-- Gives `take` the frames and the damage that a packet completes, one by one. Each has what the
-- decoder and `locate` give it, and what `Matching:received` or `Following:take` does.
function Port:feed(way, number, time, bytes, take)
  local direction, matching = self.directions[way], self.matching
  local packet = { number = number, time = time }
  if self:is_late(direction, time, #bytes, way) then
    local item = direction:unfinished(packet, self.completed)
    direction.decoder:reset()
    if item then
      take(item)
    end
  end
  direction.last_time = time
  local other = self.directions[RECEIVED].decoder
  local received = other.offset + #other.buffer
  if way == SENT then
    if not self.sent_last then
      matching:turn()
    end
    if bytes ~= "" then
      matching:begin_sending(time, received)
    end
  end
  self.sent_last = way == SENT
  if bytes == "" then
    return
  end
  direction:add(packet, bytes)
  local decoder = direction.decoder
  for item in decoder.next, decoder do
    direction:locate(item, packet, self.completed)
    if way == SENT then
      matching:sent(item, packet, received)
    else
      matching:received(item)
    end
    self.following:take(item, matching.listed, packet)
    take(item)
  end
  direction:drop_before(decoder.offset)
end
