-- A frame, or damage, in the tree of a packet.

local DIRECTIONS = { [SENT] = "sent", [RECEIVED] = "received" }
local DAMAGES = {
  checksum = { E.checksum, LABELS.expert_checksum },
  ["too long"] = { E.too_long, LABELS.expert_too_long },
  unfinished = { E.unfinished, LABELS.expert_unfinished },
}
local REFUSALS = { refused = true, not_supported = true, value_or_refusal = true }

local function computed(tree, field, value)
  return tree:add(field, value):set_generated(true)
end

local function seconds(field, tree, duration)
  local sign = duration < 0 and -1 or 1 -- a clock may have been set back
  local microseconds = math.floor(duration * sign * 1e6 + 0.5)
  local rest = microseconds % 1000000
  computed(tree, field, NSTime.new(sign * (microseconds - rest) / 1000000, sign * rest * 1000))
end

-- Returns a function that gives the range of body bytes, counted from 1, stuffing included.
local function ranges_of(bytes, wire, length)
  if not wire:find("@", 1, true) then
    return function(from, to)
      return bytes(from - 1, to - from + 1)
    end
  end
  local begins = places(wire, length)
  return function(from, to)
    return bytes(begins[from], begins[to + 1] - begins[from])
  end
end

local function show_echo(tree, item)
  if item.echo_of then
    computed(tree, F.echo, true)
    computed(tree, F.echo_of, item.echo_of.number)
  end
end

local function show_answer_of(tree, item)
  if item.sent and item.sent.response then
    computed(tree, F.response_in, item.sent.response)
  end
end

local function show_codes(tree, range, codes, from)
  for at = 1, #codes do
    tree:add(F.code, range(from + at - 1, from + at - 1), codes:byte(at))
  end
end

local function show_values(tree, range, asked, part)
  for _, each in ipairs(values_of(asked, part.value, part.from)) do
    local row, unit = each.row, each.reading.unit
    local text = row.text .. " (" .. row.name .. "): " .. shown(each)
    if type(each.value) == "number" and unit ~= "" then
      text = text:sub(1, -#unit - 1) .. " " .. unit
    end
    local value = each.value
    if type(value) == "boolean" and not IS_FLAG[row.name] then
      value = value and 1 or 0
    end
    tree:add(PARAMETERS[row.name], range(each.from, each.to), value, text)
  end
end

local function show_faults(tree, range, part)
  local numbers = part.value
  tree:add(F.fault_count, range(part.from, part.from), numbers:byte())
  for at = 2, #numbers, 2 do
    local number = numbers:byte(at)
    local row = TABLES.faults[number]
    local text = row and row.text .. " [" .. LABELS["confidence_" .. row.confidence] .. "]"
      or LABELS.unknown_fault
    text = string.format("%s %d: %s", LABELS.fault, number, text)
    local place = part.from + at - 1
    tree:add(F.fault, range(place, place), number, text):add_proto_expert_info(E.fault, text)
  end
end

local function show_parts(tree, range, asked, parts)
  for _, part in ipairs(parts) do
    local name, value = part.name, part.value
    local field = F[name]
    if name == "faults" then
      show_faults(tree, range, part)
    elseif name == "values" then
      show_values(tree, range, asked, part)
    elseif name == "codes" then
      show_codes(tree, range, value, part.from)
    elseif name == "text" then
      tree:add(F.passport, range(part.from, part.to), passport_of(value))
    elseif not field then -- bytes, datum, any
      if value ~= "" then
        tree:add(F.data, range(part.from, part.to))
      end
    else
      tree:add(field, range(part.from, part.to), value)
    end
  end
end

local function show_request(tree, range, item, asked)
  local row = TABLES.commands[item.body:byte()]
  if row then
    tree:add(F.command, range(1, 1), row.code)
    tree:add(F.name, range(1, 1), row.name)
  end
  if asked then
    show_parts(tree, range, asked, asked.parts)
  elseif row and row.request[1] == "codes" and #item.body > 1 then
    show_codes(tree, range, item.body:sub(2), 2)
  end
  if item.sent and not asked then
    tree:add_proto_expert_info(E.unknown)
  end
  show_answer_of(tree, item)
end

local function show_response(tree, range, item, asked, parts, message, time)
  local request = item.answers
  if request.body then
    computed(tree, F.request, ByteArray.new(request.body, true):tvb(LABELS.request)())
    local row = TABLES.commands[request.body:byte()]
    if row then
      computed(tree, F.command, row.code)
    end
  end
  if parts then
    show_parts(tree, range, asked, parts)
  elseif message then
    local words = meaning_of(item)
    tree:add_proto_expert_info(REFUSALS[message] and E.refused or E.unfit, words)
  end
  if request.number then
    computed(tree, F.request_in, request.number)
    seconds(F.response_time, tree, time - request.time)
  end
  if item.since then
    seconds(F.interval, tree, item.since)
  end
end

-- Returns the bytes of a frame or damage, and where they are: in this packet, or in a view of
-- their own if several packets brought them.
local function bytes_of(item, tvb)
  if item.at then
    local range = tvb(item.at, item.length)
    return range:raw(), range
  end
  return item.wire, ByteArray.new(item.wire, true):tvb(LABELS.reassembled)()
end

local function show_damage(tree, tvb, item)
  local wire, bytes = bytes_of(item, tvb)
  local info, label = DAMAGES[item.reason][1], DAMAGES[item.reason][2]
  local text = "! " .. label .. ": " .. hex(wire)
  local branch = tree:add(F.frame, bytes, text, text)
  computed(branch, F.direction, DIRECTIONS[item.way])
  computed(branch, F.damage, item.reason)
  branch:add(F.damage_data, bytes)
  branch:add_proto_expert_info(info, label .. ": " .. hex(wire))
  show_echo(branch, item)
  show_answer_of(branch, item)
  return branch, text
end

local function show_frame(tree, tvb, item, time)
  local wire, bytes = bytes_of(item, tvb)
  local words, asked, parts, message = meaning_of(item)
  local range = ranges_of(bytes, wire, #item.body)
  local text = hex(item.body)
  local row = (item.sent or item.echo_of) and TABLES.commands[item.body:byte()]
  if item.echo_of then
    words = LABELS.echo .. (row and ": " .. row.name or "")
  elseif row and not (words and words:sub(1, #row.name) == row.name) then
    words = words and row.name .. ": " .. words or row.name
  end
  local branch = tree:add(F.frame, bytes, text, text .. (words and "  " .. words or ""))
  computed(branch, F.direction, DIRECTIONS[item.way])
  branch:add(F.wire, bytes)
  if item.body ~= "" then
    local whole = range(1, #item.body)
    if whole:len() == #item.body then
      branch:add(F.body, whole)
    else
      branch:add(F.body, ByteArray.new(item.body, true):tvb(LABELS.body)())
    end
  end
  if item.sent or item.echo_of then
    show_request(branch, range, item, asked)
  else
    show_response(branch, range, item, asked, parts, message, time)
  end
  local meaning = not item.echo_of and meaning_of(item)
  if meaning then
    computed(branch, F.meaning, meaning)
  end
  branch:add(F.checksum, bytes(#wire - 2, 1), item.checksum)
  show_echo(branch, item)
  if item.raw then
    computed(branch, F.raw_checksum, true)
  end
  if item.irregular then
    computed(branch, F.irregular, true):add_proto_expert_info(E.irregular)
  end
  return branch, words or text
end

-- Shows an item in the tree of its packet; returns its text for the column Info.
local function show(tree, tvb, item, number, time)
  local show_item = item.reason and show_damage or show_frame
  local branch, text = show_item(tree, tvb, item, time)
  if item.first ~= number then
    computed(branch, F.begin, item.first)
  end
  if item.last ~= number then
    computed(branch, F.finish, item.last)
  end
  return text
end
