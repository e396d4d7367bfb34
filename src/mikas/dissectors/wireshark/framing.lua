-- Bytes to frames (protocol.md §2): checksum, byte stuffing, terminator.
--
-- A frame on the wire is body, checksum, 0D; body and checksum are stuffed. Stuffing does not
-- change the sum, so the bytes before a 0D are checked as they are (D3): sum 0 is a whole frame;
-- sum F3 and a second 0D is a frame whose checksum 0D was sent raw; all else is damage.

local TERMINATOR, ESCAPE = 0x0D, 0x40
local RAW_TERMINATOR_SUM = 0xF3
local LIMIT = 4096 -- bytes of the longest frame, without its terminator

local function sum_of(bytes)
  local sum = 0
  for at = 1, #bytes do
    sum = sum + bytes:byte(at)
  end
  return sum % 256
end

-- Returns the bytes without stuffing, whether a pair was neither 40 CD nor 40 00 (D4), and whether
-- a lone 40 is left at the end.
local function unstuffed(bytes)
  if not bytes:find("@", 1, true) then
    return bytes, false, false
  end
  local irregular, left = false, bytes
  local plain = bytes:gsub("@(.)", function(second)
    local value = second:byte()
    irregular = irregular or (value ~= 0xCD and value ~= 0x00)
    return string.char((ESCAPE + value) % 256)
  end)
  left = bytes:gsub("@.", "")
  return plain, irregular, left:sub(-1) == "@"
end

-- Returns, for a body of `length` bytes in `wire`, where each byte begins in it, from 0; the last
-- entry is the place behind the body.
local function places(wire, length)
  local found, at = {}, 0
  for index = 1, length + 1 do
    found[index] = at
    at = at + (wire:byte(at + 1) == ESCAPE and 2 or 1)
  end
  return found
end

local Decoder = {}
Decoder.__index = Decoder

local function new_decoder()
  -- `start`: of the next frame in the buffer; `searched`: where to look for its terminator.
  -- `offset`: of the buffer in the stream.
  return setmetatable(
    { buffer = "", start = 1, searched = 1, offset = 0, overflowed = false }, Decoder)
end

function Decoder:drop(count)
  self.buffer = self.buffer:sub(count + 1)
  self.offset = self.offset + count
  self.start = math.max(1, self.start - count)
  self.searched = math.max(1, self.searched - count)
end

-- Drops the unfinished frame and returns its bytes.
function Decoder:reset()
  local dropped = self.buffer
  self:drop(#dropped)
  self.overflowed = false
  return dropped
end

-- Returns the body and the checksum of a frame on the wire, whether it has an irregular escape, and
-- whether its checksum is a lone 40. `is_double`: its checksum is a raw 0D.
local function body_of(wire, is_double)
  if is_double then
    local body, irregular, lone = unstuffed(wire:sub(1, -3))
    return body, TERMINATOR, irregular or lone, false
  end
  local plain, irregular, lone = unstuffed(wire:sub(1, -2))
  return plain:sub(1, -2), plain:byte(-1), irregular, lone
end

local function sound_frame(wire, offset, is_double)
  local body, _, irregular, lone = body_of(wire, is_double)
  return {
    body = body, wire = wire, offset = offset, is_double = is_double or nil,
    raw = lone or is_double or nil, irregular = irregular or nil,
  }
end

local function damaged(reason, bytes, offset)
  return { reason = reason, wire = bytes, offset = offset }
end

function Decoder:add(bytes)
  self.buffer = self.buffer .. bytes
end

-- Returns the next frame or damage that the bytes so far complete, or nil.
function Decoder:next()
  local buffer = self.buffer
  while true do
    local stop = buffer:find("\r", self.searched, true)
    if not stop then
      self.searched = #buffer + 1
      return self:rest()
    end
    local event, next_start = nil, stop + 1
    if self.overflowed then
      self.overflowed = false
    else
      local part, offset = buffer:sub(self.start, stop - 1), self.offset + self.start - 1
      local sum = sum_of(part)
      if #part > LIMIT then
        event = damaged("too long", part:sub(1, LIMIT), offset)
      elseif part == "" then
        -- A bare terminator is line noise (D5).
      elseif sum == 0 then
        event = sound_frame(part .. "\r", offset)
      elseif sum == RAW_TERMINATOR_SUM and next_start > #buffer then
        self.searched = stop -- the next byte decides
        return self:rest()
      elseif sum == RAW_TERMINATOR_SUM and buffer:byte(next_start) == TERMINATOR then
        event = sound_frame(part .. "\r\r", offset, true)
        next_start = next_start + 1
      else
        event = damaged("checksum", part, offset)
      end
    end
    self.start, self.searched = next_start, next_start
    if event then
      return event
    end
  end
end

-- Drops what has been returned; returns an unfinished frame that is too long.
function Decoder:rest()
  self:drop(self.start - 1)
  if self.overflowed then
    self:drop(#self.buffer)
  elseif self.searched > LIMIT + 1 then
    local event = damaged("too long", self.buffer:sub(1, LIMIT), self.offset)
    self:drop(#self.buffer)
    self.overflowed = true
    return event
  end
end
