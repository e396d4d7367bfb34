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

-- Returns each value of a response: `row` of its parameter, `conversion`, `value`, its `text` as `85°C`
-- or `1` of a flag, and the bytes `from`, `to` of the body.
local function values_of(asked, bytes, from)
  local values, at, chosen = {}, 1, interpretation()
  for index = 1, #asked.codes do
    local rows = parameters_of[asked.codes:byte(index)]
    local size = rows[1].size
    local raw = bytes:sub(at, at + size - 1)
    for _, row in ipairs(rows) do
      local conversion = row.interpretations[chosen]
      local value = value_of(conversion, raw)
      local text = value == true and "1" or value == false and "0"
        or row.form:format(value) .. conversion.unit
      values[#values + 1] = {
        row = row, conversion = conversion, value = value, text = text,
        from = from + at - 1, to = from + at + size - 2,
      }
    end
    at = at + size
  end
  return values
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
    parts.values.list = values_of(asked, parts.values.value, parts.values.from)
    local words = {}
    for index, each in ipairs(parts.values.list) do
      words[index] = each.row.name .. "=" .. each.text
    end
    return table.concat(words, " ")
  elseif parts.bytes or parts.any then
    return hex((parts.bytes or parts.any).value)
  end
  return string.format("%02X", parts.value.value)
end

-- Returns what a frame means, or nil; the parsed request (of the frame itself, or that it answers);
-- the parts of a response, with a `list` of its values; the name of the message of a response that
-- says nothing else.
local function meaning_of(item, body)
  if item.echo_of then
    return nil
  elseif item.sent then
    local asked = asked_by(body, item.listed)
    return asked and words_of_request(asked), asked
  end
  local request = item.answers and item.answers.body
  local asked = request and asked_by(request, item.listed)
  if not asked then
    return nil
  end
  local parts, message, fields = parsed_response(asked, body)
  if not parts then
    return filled(TABLES.messages[message], fields), asked, nil, message
  elseif may_be_refusal(asked, body, item.is_first) then
    return TABLES.messages.value_or_refusal, asked, nil, "value_or_refusal"
  end
  return words_of_parts(asked, parts), asked, parts
end
