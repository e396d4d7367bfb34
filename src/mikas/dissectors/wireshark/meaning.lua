-- What a request asks and what its response says (protocol.md §3, §4), by the layouts in TABLES.
--
-- A request is parsed into `asked`: `row` of the command, and `parts`. A response is parsed into
-- `parts`, or into the name and the fields of a message. A part is `{ name, value, from, to }`:
-- its bytes in the body, counted from 1.

local REFUSAL = "\1"
local SEPARATOR = 0xE0
local READ_LIST, WRITE_LIST = 0x63, 0x64
local TEXT_LENGTH = 16
local MOST_REQUESTS = 4096 -- that are remembered

local parameters_of = {} -- by code, in the catalog's order
for _, row in ipairs(TABLES.parameters) do
  parameters_of[row.code] = parameters_of[row.code] or {}
  table.insert(parameters_of[row.code], row)
  row.form = "%." .. row.decimals .. "f"
end

local HEX = {} -- by character
for byte = 0, 255 do
  HEX[string.char(byte)] = string.format("%02X ", byte)
end

local function hex(bytes)
  return (bytes:gsub(".", HEX):sub(1, -2))
end

-- Returns a number from bytes, the low one first.
local function number_of(bytes, signed)
  local number, scale = 0, 1
  for at = 1, #bytes do
    number = number + bytes:byte(at) * scale
    scale = scale * 256
  end
  if signed and number >= scale / 2 then
    number = number - scale
  end
  return number
end

-- Returns whether `number` has a bit of `mask`; no Lua of Wireshark's has the same operators.
local function has_bit_of(number, mask)
  while mask > 0 do
    if number % 2 == 1 and mask % 2 == 1 then
      return true
    end
    number, mask = math.floor(number / 2), math.floor(mask / 2)
  end
  return false
end

local function microseconds(seconds)
  return math.floor(seconds * 1e6 + 0.5)
end

-- Returns the value of a parameter: a number, exact as the catalog's, or a boolean.
local function value_of(conversion, bytes)
  local number = number_of(bytes, conversion.signed)
  if conversion.mask ~= 0 then
    return has_bit_of(number, conversion.mask)
  end
  return (number * conversion.numerator + conversion.constant) / conversion.denominator
end

local function sizes_of(codes)
  local sum = 0
  for at = 1, #codes do
    sum = sum + parameters_of[codes:byte(at)][1].size
  end
  return sum
end

local SIZES = { count = 1, value = 1, code = 1, model = 1, result = 1, text = TEXT_LENGTH }

-- Splits `body` from `at` on into the parts of a layout; nil if it has another length.
local function split(row, layout, body, at, count)
  local parts = {}
  for _, name in ipairs(layout) do
    local size = SIZES[name]
    if name == "address" then
      size = row.address_bytes
    elseif name == "bytes" then
      size = count or parts.count and parts.count.value
    elseif not size then -- the rest
      size = #body - at + 1
      if size < 1 and (name == "codes" or name == "datum") then
        return nil
      end
    end
    local bytes = body:sub(at, at + size - 1)
    if #bytes < size then
      return nil
    end
    local is_number = SIZES[name] == 1 or name == "address"
    local part = { name = name, from = at, to = at + size - 1 }
    part.value = is_number and number_of(bytes) or bytes
    parts[name] = part
    parts[#parts + 1] = part
    at = at + size
  end
  return at == #body + 1 and parts or nil
end

local function are_known(codes)
  for at = 1, #codes do
    if not parameters_of[codes:byte(at)] then
      return false
    end
  end
  return true
end

local function parsed_request(body)
  local row = TABLES.commands[body:byte()]
  local parts = row and split(row, row.request, body, 2)
  if not parts then
    return nil
  end
  if parts.count then
    local last = parts.address.value + parts.count.value
    if parts.count.value < 1 or last > 256 ^ row.address_bytes then
      return nil
    end
  end
  if parts.codes and not are_known(parts.codes.value) then
    return nil
  end
  return { row = row, parts = parts, codes = parts.codes and parts.codes.value or "", body = body }
end

local remembered, remembered_count = {}, 0

-- Returns the parsed request, or nil if it is none of §3. `listed`: the codes of the unit's list.
local function asked_by(body, listed)
  local asked = remembered[body]
  if asked == nil then
    if remembered_count == MOST_REQUESTS then
      remembered, remembered_count = {}, 0
    end
    asked = parsed_request(body) or false
    remembered[body], remembered_count = asked, remembered_count + 1
  end
  if asked and asked.row.code == READ_LIST then
    return listed and { row = asked.row, parts = asked.parts, codes = listed, body = body } or nil
  end
  return asked or nil
end

-- Returns the length of a response; nil if it has many.
local function length_of(asked, layout)
  local length = 0
  for _, name in ipairs(layout) do
    if name == "faults" or name == "any" then
      return nil
    elseif name == "values" then
      length = length + sizes_of(asked.codes)
    elseif name == "address" then
      length = length + asked.row.address_bytes
    elseif name == "bytes" then
      length = length + asked.parts.count.value
    else
      length = length + SIZES[name]
    end
  end
  return length
end

local function fits(asked, layout, body)
  if layout[1] == "faults" then
    return #body % 2 == 1 and #body <= 511
  end
  return layout[1] == "any" or #body == length_of(asked, layout)
end

local function unfit(asked, body)
  if body == REFUSAL then
    return "not_supported", { command = asked.row.shown }
  end
  local lengths = {}
  for index, layout in ipairs(asked.row.responses) do
    lengths[index] = length_of(asked, layout) or "1, 3, 5 …"
  end
  return "wrong_length", { length = #body, expected = table.concat(lengths, " / ") }
end

-- Returns the message and its fields if the content of a response of the right length is invalid.
local function problem_of(asked, parts, body)
  local address, count = asked.parts.address, asked.parts.count
  if parts.address and parts.address.value ~= address.value then
    local form = "%0" .. 2 * asked.row.address_bytes .. "X"
    local got, sent = form:format(parts.address.value), form:format(address.value)
    return "wrong_address", { got = got, asked = sent }
  end
  if parts.count and parts.count.value ~= count.value then
    return "other_count", { announced = parts.count.value, asked = count.value }
  end
  if parts.result and parts.result.value == 1 then
    return "refused", {}
  elseif parts.result and parts.result.value ~= 0 then
    return "no_completion_code", { code = hex(body) }
  end
  if parts.faults then
    if body == REFUSAL then
      return "not_supported", { command = asked.row.shown }
    end
    local held = (#body - 1) / 2
    if body:byte() ~= held then
      return "other_number_of_faults", { announced = body:byte(), held = string.format("%d", held) }
    end
    for at = 3, #body, 2 do
      if body:byte(at) ~= SEPARATOR then
        return "no_separator", {}
      end
    end
  end
end

-- Returns the parts of a response; else nil, the name of a message, and its fields.
local function parsed_response(asked, body)
  for _, layout in ipairs(asked.row.responses) do
    if fits(asked, layout, body) then
      local parts = split(asked.row, layout, body, 1, asked.parts.count and asked.parts.count.value)
      local message, fields = problem_of(asked, parts, body)
      if message then
        return nil, message, fields
      end
      return parts
    end
  end
  return nil, unfit(asked, body)
end

-- Returns whether a lone 01 may be a value of 01 or a refusal (D10): of a single code of one byte,
-- and of a stream its first response.
local function may_be_refusal(asked, body, first)
  local row = asked.row
  local names_codes = row.request[1] == "codes" and row.responses[1][1] == "values"
  return names_codes and (first or not row.stream) and #asked.codes == 1 and body == REFUSAL
end

local REFUSALS = { refused = true, not_supported = true, value_or_refusal = true }

-- Returns whether `body` fits a request: by length, address and content, or as a refusal; all fits
-- one that is not known. `listed`: the codes of the unit's list, as in `asked_by`.
local function may_answer(request, body, listed)
  local asked = asked_by(request, listed)
  if not asked then
    return true
  elseif asked.row.responses[1][1] == "values" then
    return body == REFUSAL or #body == sizes_of(asked.codes)
  end
  local parts, message = parsed_response(asked, body)
  return parts ~= nil or REFUSALS[message] == true
end

-- What a line's frames need to be read later: `started`, the request that was sent last and has not
-- been answered.
local Following = {}
Following.__index = Following

local function new_following()
  return setmetatable({}, Following)
end

-- Completes a frame of a packet: `listed`, the unit's list where 63 needs it; of a response, whether
-- it `is_first`, its `delay` behind the request and, in a stream, the time `since` the one before.
function Following:take(item, listed, packet)
  local answers = item.answers
  local request = item.sent and item.body or answers and answers.body
  if not request then
    return
  end
  item.listed = request:byte() == READ_LIST and listed or nil
  if answers then
    local row = TABLES.commands[request:byte()]
    item.delay = microseconds(packet.time - answers.time)
    if row and row.stream and answers.latest then
      item.since = microseconds(packet.time - answers.latest)
    end
    answers.latest = packet.time
  end
  if asked_by(request, listed) then
    item.is_first = self.started == request
    self.started = item.sent and request or nil
  end
end
