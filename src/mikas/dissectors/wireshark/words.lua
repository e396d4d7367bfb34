-- What a frame says in words, as `mikas decode` prints it.

local function filled(template, fields)
  return (template:gsub("{([%w_]+)}", fields))
end

local function passport_of(bytes)
  local characters = {}
  for at = 1, #bytes:gsub("\0+$", "") do
    characters[at] = CODE_PAGE[bytes:byte(at) + 1]
  end
  return table.concat(characters)
end

-- Returns each value of a response: `row` of its parameter, `value`, `reading`, and its bytes.
local function values_of(asked, bytes, from)
  local values, at = {}, 1
  for index = 1, #asked.codes do
    local rows = parameters_of[asked.codes:byte(index)]
    local size = rows[1].size
    for _, row in ipairs(rows) do
      local value, reading = value_of(row, bytes:sub(at, at + size - 1))
      values[#values + 1] = {
        row = row, value = value, reading = reading, from = from + at - 1, to = from + at + size - 2,
      }
    end
    at = at + size
  end
  return values
end

-- Returns `85°C`, or `1` of a flag.
local function shown(each)
  if type(each.value) == "boolean" then
    return each.value and "1" or "0"
  end
  local number = string.format("%." .. string.format("%d", each.row.decimals) .. "f", each.value)
  return number .. (each.reading.mask == 0 and each.reading.unit or "")
end

local function words_of_request(asked)
  local names = {}
  if asked.row.code ~= READ_LIST then
    for at = 1, #asked.codes do
      names[at] = CODE_NAMES[asked.codes:byte(at)]
    end
  end
  local title = asked.row.title
  return #names > 0 and title .. ": " .. table.concat(names, " ") or title
end

local function words_of_parts(asked, parts)
  local messages = TABLES.messages
  if parts.model then
    local code = parts.model.value
    local unknown = filled(messages.unknown_model, { code = string.format("%02X", code) })
    return TABLES.models[code] or unknown
  elseif parts.faults then
    local numbers = {}
    for at = 2, #parts.faults.value, 2 do
      numbers[#numbers + 1] = string.format("%d", parts.faults.value:byte(at))
    end
    local text = #numbers > 0 and table.concat(numbers, " ") or "0"
    return filled(messages.faults, { numbers = text })
  elseif parts.text then
    return filled(messages.text, { text = passport_of(parts.text.value) })
  elseif parts.result then
    return messages.done
  elseif parts.values then
    local values = {}
    for index, each in ipairs(values_of(asked, parts.values.value, parts.values.from)) do
      values[index] = each.row.name .. "=" .. shown(each)
    end
    return table.concat(values, " ")
  elseif parts.bytes or parts.any then
    return hex((parts.bytes or parts.any).value)
  end
  return string.format("%02X", parts.value.value)
end

-- Returns what a frame means, or nil; the parsed request (of the frame itself, or that it answers);
-- the parts of a response; the name of the message of a response that says nothing else.
local function meaning_of(item)
  if item.echo_of then
    return nil
  elseif item.sent then
    local asked = asked_by(item.body, item.listed)
    return asked and words_of_request(asked), asked
  end
  local request = item.answers and item.answers.body
  local asked = request and asked_by(request, item.listed)
  if not asked then
    return nil
  end
  local parts, message, fields = parsed_response(asked, item.body)
  if not parts then
    return filled(TABLES.messages[message], fields), asked, nil, message
  elseif may_be_refusal(asked, item.body, item.is_first) then
    return TABLES.messages.value_or_refusal, asked, nil, "value_or_refusal"
  end
  return words_of_parts(asked, parts), asked, parts
end
