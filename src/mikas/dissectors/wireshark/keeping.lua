-- What the first pass has found, for the later ones, which come in any order: a few bytes a frame.
--
-- The bytes of a frame are in its packet, so only their place is kept, from the end of the frame
-- before, and what can't be concluded from them. A number is in bytes of seven bits, the low ones
-- first; the high bit says that more follow.

local REASONS = { "checksum", "too long", "unfinished" }
local DOUBT_NAMES = {}
for name in pairs(DOUBTS) do
  DOUBT_NAMES[#DOUBT_NAMES + 1] = name
end
local MARKS = { "sent", "raw", "irregular", "is_double", "is_first" }

local function place_by_name(names)
  local places = {}
  for place, name in ipairs(names) do
    places[name] = place
  end
  return places
end

local REASON_NUMBERS, DOUBT_NUMBERS = place_by_name(REASONS), place_by_name(DOUBT_NAMES)

local Writer = {}
Writer.__index = Writer

function Writer:put(number)
  while number >= 128 do
    self[#self + 1] = string.char(number % 128 + 128)
    number = math.floor(number / 128)
  end
  self[#self + 1] = string.char(number)
end

function Writer:put_signed(number) -- a clock may have been set back
  self:put(number < 0 and -2 * number - 1 or 2 * number)
end

-- Numbers of texts that many frames have in common: requests, and lists of the unit.
local texts_kept, number_of_text

local function forget_texts()
  texts_kept, number_of_text = {}, {}
end

local function text_number(text)
  if not number_of_text[text] then
    texts_kept[#texts_kept + 1] = text
    number_of_text[text] = #texts_kept
  end
  return number_of_text[text]
end

-- All frames of a packet as one text. `at`: the end of the last one.
local Kept = {}
Kept.__index = Kept

local function new_kept(number)
  return setmetatable({ number = number, at = 0, writer = setmetatable({}, Writer) }, Kept)
end

function Kept:take(item)
  local writer, marks = self.writer, 0
  for place, name in ipairs(MARKS) do
    marks = marks + (item[name] and 2 ^ place or 0)
  end
  writer:put(marks + (item.at and 0 or 1))
  if item.at then
    writer:put(item.at - self.at)
    writer:put(#item.wire)
    self.at = item.at + #item.wire
  else
    writer:put(#item.wire)
    writer[#writer + 1] = item.wire
    writer:put(self.number - item.first)
    writer:put(self.number - item.last)
  end
  self:take_role(item)
end

function Kept:take_role(item)
  local writer = self.writer
  writer:put(2 * (REASON_NUMBERS[item.reason] or 0) + (item.listed and 1 or 0))
  if item.listed then
    writer:put(text_number(item.listed))
  end
  if item.echo_of then
    writer:put(1)
    writer:put(self.number - item.echo_of)
  elseif item.answers then
    writer:put(item.since and 3 or 2)
    writer:put(text_number(item.answers.body))
    writer:put(self.number - item.answers.number)
    writer:put_signed(item.delay)
    if item.since then
      writer:put_signed(item.since)
    end
  else
    writer:put(item.doubt and 3 + DOUBT_NUMBERS[item.doubt] or 0)
  end
end

-- `open`: bytes behind them, of a frame that goes on in other packets.
function Kept:text(open)
  local head = setmetatable({}, Writer)
  head:put(open)
  return table.concat(head) .. table.concat(self.writer)
end

local Reader = {}
Reader.__index = Reader

-- Returns a reader of the text that packet `number` has, and its `open` bytes.
local function new_reader(text, number, way)
  local reader = setmetatable(
    { text = text, place = 1, number = number, way = way, at = 0 }, Reader)
  return reader, reader:get()
end

function Reader:get()
  local number, scale = 0, 1
  while true do
    local byte = self.text:byte(self.place)
    self.place = self.place + 1
    number = number + byte % 128 * scale
    if byte < 128 then
      return number
    end
    scale = scale * 128
  end
end

function Reader:get_signed()
  local number = self:get()
  return number % 2 == 1 and -(number + 1) / 2 or number / 2
end

-- Returns the next frame or damage, or nil.
function Reader:next()
  if self.place > #self.text then
    return nil
  end
  local marks, item = self:get(), { way = self.way, first = self.number, last = self.number }
  for place, name in ipairs(MARKS) do
    item[name] = marks % (2 * 2 ^ place) >= 2 ^ place or nil
  end
  if marks % 2 == 0 then
    item.at = self.at + self:get()
    item.length = self:get()
    self.at = item.at + item.length
  else
    local length = self:get()
    item.wire = self.text:sub(self.place, self.place + length - 1)
    self.place = self.place + length
    item.first = self.number - self:get()
    item.last = self.number - self:get()
  end
  self:get_role(item)
  return item
end

function Reader:get_role(item)
  local reason = self:get()
  item.reason = REASONS[math.floor(reason / 2)]
  item.listed = reason % 2 == 1 and texts_kept[self:get()] or nil
  local role = self:get()
  if role == 1 then
    item.echo_of = self.number - self:get()
  elseif role == 2 or role == 3 then
    item.answers = { body = texts_kept[self:get()] }
    item.answers.number = self.number - self:get()
    item.delay = self:get_signed()
    item.since = role == 3 and self:get_signed() or nil
  else
    item.doubt = DOUBT_NAMES[role - 3]
  end
end
