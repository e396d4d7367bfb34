-- Which frame is an echo, and which request a response answers (protocol.md D1, D13): the rules of
-- mikas.recording.exchanges.matching, which explains them, in the same order.

local PATIENCE = 0.51
local GIVEN_UP = 0.9
local SOON = 0.5
local MARGIN = 1.25
local AT_ONCE = 10
local MOST_UNECHOED = 64
local AVAILABILITY = "\1"
local MODELS = { ["\9"] = true, ["\10"] = true }

-- A request: `body` (nil: not known, or damaged), `number` and `time` of its packet, and `latest`,
-- the time of its last response.
local UNKNOWN = {}
-- How far an exchange has come.
local ASKED, ECHOED, STREAMING, ANSWERED, LATE, VOID = 1, 2, 3, 4, 5, 6

local Matching = {}
Matching.__index = Matching

-- `listed`: the codes of the unit's list; nil: not known. `is_partial`, `is_damaged`: what was sent
-- may be a 64. `phase`: nil without a known request.
local function new_matching()
  return setmetatable({
    request = UNKNOWN, trusted = true, patience = PATIENCE, unechoed = {}, wire = "", from = 0,
    sent_until = -math.huge, due = -math.huge, delay = 0, answered_at = -math.huge, answer = "",
  }, Matching)
end

local function asks_stream(body)
  local row = body and TABLES.commands[body:byte()]
  return row and row.stream or false
end

-- A part of the recording is missing, perhaps with a request in it. A stream continues.
function Matching:interrupt()
  self:lose_list()
  if self.phase ~= STREAMING then
    self.request, self.phase, self.trusted = UNKNOWN, nil, true
  end
end

function Matching:lose_list()
  self.listed, self.is_partial, self.is_damaged = nil, false, false
end

-- Sending begins after receiving: missing echoes will not follow any more.
function Matching:turn()
  self.unechoed = {}
  if self.is_partial or self.is_damaged then
    self:lose_list()
  end
end

-- The exchange before is over: a byte of the next request was sent at `time`, behind so many
-- received ones.
function Matching:begin_sending(time, received)
  local phase = self.phase
  self.phase, self.from = nil, received
  self.is_damaged = self.is_damaged or self.is_partial
  self.is_partial = true
  if phase == LATE and self:has_waited(time) then
    self.trusted_before = self.trusted
  end
  if not phase then
    return
  elseif phase == STREAMING then
    self.trusted = false
  elseif phase ~= ANSWERED then
    -- Without an echo, a response may look like its request.
    self.trusted = self.trusted and phase == ECHOED and self.echoes == false
  elseif self.request.body == AVAILABILITY then
    self:confirm()
  end
end

-- Returns whether the tester, which sends again at `time`, may have taken a late response.
function Matching:has_waited(time)
  local is_quick = time < self.sent_until + GIVEN_UP
  local is_patient = self.delay > GIVEN_UP and time < self.answered_at + SOON
  return is_quick or is_patient
end

-- Trusts as before a late response, which the tester has taken.
function Matching:learn_patience(trusted)
  local is_availability = self.request.body == AVAILABILITY
  if trusted or is_availability then
    self.patience = math.max(self.patience, MARGIN * self.delay)
    self.trusted = trusted
    if is_availability then
      self:confirm()
    end
  end
end

-- Judges a clean answer to 01.
function Matching:confirm()
  local version, before = self.answer, self.last_version
  self.last_version = version
  local is_own = version == self.version or (not self.version and MODELS[version])
  if is_own or version == before then
    self.version = version
    self.trusted = true
  elseif self.version then
    self.trusted = false
  end
end

-- Takes a sent frame, or damage, of a packet. `received`: bytes received before it.
function Matching:sent(it, packet, received)
  if self.phase then -- more than one in a packet
    self.is_partial = false
    self:begin_sending(it.began, received)
  end
  if it.body and self.is_damaged then
    self:lose_list()
  end
  local before = self.trusted_before
  self.trusted_before = nil
  if before ~= nil and it.body and it.body ~= AVAILABILITY then
    self:learn_patience(before)
  end
  it.sent = true
  self.request = { body = it.body, number = packet.number, time = packet.time }
  table.insert(self.unechoed, { wire = it.wire, number = packet.number })
  if #self.unechoed > MOST_UNECHOED then
    table.remove(self.unechoed, 1)
  end
  self.is_partial = false
  if not it.body then
    self.is_damaged = true
    return
  end
  self.phase = ASKED
  self.wire, self.from = it.wire, received
  self.sent_until = it.began + #it.wire * byte_time()
  self.due = self.sent_until
  if it.body:byte() == WRITE_LIST then
    self.listed = nil
  end
end

-- Gives a received frame, or damage, one of `echo_of`, the packet of what it repeats, `answers`, a
-- request, and, if it is a frame, `doubt`: why it answers none.
function Matching:received(it)
  local was_sent = self:place_of(it.wire)
  if not self.phase or it.offset + #it.wire <= self.from then
    self:judge_list(it)
    return self:apart(it, "NO_REQUEST", was_sent)
  end
  if self.phase == ASKED then
    if was_sent and it.wire == self.wire and it.offset == self.from then
      return self:echo(it, was_sent)
    end
    if self.echoes or was_sent then
      self.phase = VOID
      return self:apart(it, "NO_ECHO", was_sent)
    end
  end
  if was_sent or self.phase >= ANSWERED then
    local doubt = self.phase == ANSWERED and "SECOND" or "FAILED"
    if self.phase == ECHOED and it.wire == self.wire and self.request.body ~= AVAILABILITY then
      self.phase = ANSWERED -- the tester took it for the response, perhaps rightly
    elseif self.phase ~= STREAMING then
      self.phase = VOID
    end
    return self:apart(it, doubt, was_sent)
  end
  self:response(it)
end

-- Learns from the echo of a request that is not known whether it was a 64.
function Matching:judge_list(it)
  if self.echoes and it.offset == self.from and (self.is_partial or self.is_damaged) then
    if not it.body or it.body:byte() == WRITE_LIST then
      self:lose_list()
    end
    self.is_partial, self.is_damaged = false, false
  end
end

function Matching:place_of(wire)
  for place, sent in ipairs(self.unechoed) do
    if sent.wire == wire then
      return place
    end
  end
end

-- Returns the packet of a sent frame whose echo has come; those before it have none.
function Matching:echoed(place)
  for _ = 2, place do
    table.remove(self.unechoed, 1)
  end
  return self.unechoed[1].number
end

function Matching:apart(it, doubt, was_sent)
  if was_sent then
    it.echo_of = self:echoed(was_sent)
    if self.request.body == AVAILABILITY and it.wire == self.wire then
      self.echoes = true
    end
  elseif it.body then
    it.doubt = doubt
    if it.body:byte() == WRITE_LIST or it.body == "\0" then -- all that is left of a 64
      self:lose_list()
    end
  end
end

function Matching:echo(it, was_sent)
  it.echo_of = self:echoed(was_sent)
  self.due = math.max(self.due, it.ended)
  self.phase = asks_stream(self.request.body) and STREAMING or ECHOED
  if self.request.body == AVAILABILITY then
    self.echoes = true
  end
end

-- Judges the first thing behind a request and its echo, or any of a stream.
function Matching:response(it)
  local request = self.request.body
  if asks_stream(request) then
    self.phase = STREAMING
    return it.body and self:answered(it)
  end
  local was_echoed = self.phase == ECHOED
  self.phase = VOID
  if not it.body then
    return
  end
  if it.followed then
    it.doubt = "TOGETHER"
    return
  end
  if not was_echoed and not self.echoes and self:is_too_soon(it.wire_time) then
    it.doubt = "TOO_SOON"
    return
  end
  local delay = it.began - self.due
  if delay > self.patience then
    self.phase, self.delay, self.answered_at, self.answer = LATE, delay, it.ended, it.body
    it.doubt = "LATE"
    return
  end
  if not may_answer(request, it.body, self.listed) then
    return self:answered(it) -- shown as what it is; no value comes of it
  end
  self.phase = ANSWERED
  if request == AVAILABILITY then
    return self:version_answered(it)
  end
  self.echoes = self.echoes or was_echoed
  if self.trusted and request:byte() == WRITE_LIST and it.body == "\0" then
    local asked = asked_by(request)
    self.listed = asked and asked.codes
  end
  self:answered(it)
end

-- Returns whether a response without an echo began before its request was out (D2). An emulator
-- without a wire may answer so, as its answer to 01 shows, or to a recording's first request.
function Matching:is_too_soon(wire_time)
  if wire_time >= self.due - byte_time() / 2 then
    self.at_once = math.max(0, (self.at_once or 0) - 1)
  elseif self.at_once ~= 0 or self.request.body == AVAILABILITY then
    self.at_once = AT_ONCE
  else
    return true
  end
  return false
end

function Matching:version_answered(it)
  local version = it.body
  if version == REFUSAL then
    self.phase = VOID
    it.doubt = "FAILED"
    return
  end
  if self.echoes == nil and it.offset == self.from then
    self.echoes = false
  end
  self.answer = version
  local is_other = self.version and version ~= self.version and version ~= self.last_version
  if not self.trusted and is_other then
    it.doubt = "NOT_IN_SYNC"
  else
    it.answers = self.request
  end
end

function Matching:answered(it)
  if self.trusted then
    it.answers = self.request
  else
    it.doubt = "NOT_IN_SYNC"
  end
end
