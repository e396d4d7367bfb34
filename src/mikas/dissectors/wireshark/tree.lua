-- A frame, or damage, in the tree of a packet.
--
-- While a tree is not shown (`visible`), only fields that a filter or a column needs are added:
-- most of the time of a long recording would go into the others.

local DIRECTIONS = { [SENT] = "sent", [RECEIVED] = "received" }
local DAMAGES = {
  checksum = { E.checksum, LABELS.expert_checksum },
  ["too long"] = { E.too_long, LABELS.expert_too_long },
  unfinished = { E.unfinished, LABELS.expert_unfinished },
}
local OTHER_RESULTS = { refused = true, no_completion_code = true } -- than 00

local visible = true -- of the present packet

local function wants(tree, field)
  return visible or tree:referenced(field)
end

local function add(tree, field, ...)
  if visible or tree:referenced(field) then
    return tree:add(field, ...)
  end
end

local function computed(tree, field, value)
  if visible or tree:referenced(field) then
    return tree:add(field, value):set_generated(true)
  end
end

local function duration(field, tree, count) -- of microseconds
  local sign = count < 0 and -1 or 1
  local rest = count * sign % 1000000
  computed(tree, field, NSTime.new(sign * (count * sign - rest) / 1000000, sign * rest * 1000))
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

local function show_direction(tree, way)
  local item = computed(tree, F.direction, DIRECTIONS[way])
  if item and visible then
    item:set_text(LABELS.direction .. ": " .. LABELS[DIRECTIONS[way]])
  end
end

local function show_echo(tree, item)
  if item.echo_of then
    computed(tree, F.echo, true)
    computed(tree, F.echo_of, item.echo_of)
  end
end

local function show_codes(tree, range, codes, from)
  if wants(tree, F.code) then
    for at = 1, #codes do
      tree:add(F.code, range(from + at - 1, from + at - 1), codes:byte(at))
    end
  end
end

-- Returns `Coolant temperature (TWAT): 85 °C`.
local function label_of(each)
  local unit = each.conversion.mask == 0 and each.conversion.unit or ""
  local text = each.text:sub(1, -#unit - 1)
  return each.row.text .. " (" .. each.row.name .. "): " .. text .. (unit ~= "" and " " .. unit or "")
end

local function show_values(tree, range, part)
  for _, each in ipairs(part.list) do
    local field = PARAMETERS[each.row.name]
    if visible or tree:referenced(field) then
      local value = each.value
      if not IS_FLAG[each.row.name] and type(value) == "boolean" then
        value = value and 1 or 0
      end
      tree:add(field, range(each.from, each.to), value, label_of(each))
    end
  end
end

local function show_faults(tree, range, part)
  local numbers = part.value
  add(tree, F.fault_count, range(part.from, part.from), numbers:byte())
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

local function show_parts(tree, range, parts)
  for _, part in ipairs(parts) do
    local name, value = part.name, part.value
    local field = F[name]
    if name == "faults" then
      show_faults(tree, range, part)
    elseif name == "values" then
      show_values(tree, range, part)
    elseif name == "codes" then
      show_codes(tree, range, value, part.from)
    elseif name == "text" then
      add(tree, F.passport, range(part.from, part.to), passport_of(value))
    elseif field then
      add(tree, field, range(part.from, part.to), value)
    elseif value ~= "" then -- bytes, datum, any
      add(tree, F.data, range(part.from, part.to))
    end
  end
end

local function show_request(tree, range, item, body, asked)
  local row = TABLES.commands[body:byte()]
  if row then
    add(tree, F.command, range(1, 1), row.code)
    add(tree, F.name, range(1, 1), row.name)
  end
  if asked then
    show_parts(tree, range, asked.parts)
  elseif row and row.request[1] == "codes" and #body > 1 then
    show_codes(tree, range, body:sub(2), 2)
  end
  if item.sent and not asked then
    tree:add_proto_expert_info(E.unknown)
  end
  if item.response then
    computed(tree, F.response_in, item.response)
  end
end

local function show_response(tree, range, item, said)
  local request = item.answers
  if wants(tree, F.request) then -- as text: other bytes would have a view of their own
    computed(tree, F.request, hex(request.body))
  end
  local row = TABLES.commands[request.body:byte()]
  if row then
    computed(tree, F.command, row.code)
  end
  if said.parts then
    show_parts(tree, range, said.parts)
  elseif said.message then
    if OTHER_RESULTS[said.message] then
      add(tree, F.result, range(1, 1), said.body:byte())
    end
    tree:add_proto_expert_info(REFUSALS[said.message] and E.refused or E.unfit, said.words)
  end
  computed(tree, F.request_in, request.number)
  duration(F.response_time, tree, item.delay)
  if item.since then
    duration(F.interval, tree, item.since)
  end
end

-- Returns the bytes of a frame or damage, and where they are: in this packet, or in a view of
-- their own if several packets brought them.
local function bytes_of(item, tvb)
  if item.at then
    local range = tvb(item.at, item.length or #item.wire)
    return item.wire or range:raw(), range
  end
  return item.wire, ByteArray.new(item.wire, true):tvb(LABELS.reassembled)()
end

local function show_damage(tree, item, wire, bytes)
  local info, label = DAMAGES[item.reason][1], DAMAGES[item.reason][2]
  local words = label .. ": " .. hex(wire)
  local branch = tree:add(F.frame, bytes, "! " .. words, "! " .. words)
  show_direction(branch, item.way)
  computed(branch, F.damage, item.reason)
  add(branch, F.damage_data, bytes)
  branch:add_proto_expert_info(info, words)
  show_echo(branch, item)
  return branch, "! " .. words
end

local function show_body(tree, range, body)
  if body ~= "" and wants(tree, F.body) then
    local whole = range(1, #body)
    if whole:len() == #body then
      tree:add(F.body, whole)
    else
      tree:add(F.body, ByteArray.new(body, true):tvb(LABELS.body)())
    end
  end
end

-- Returns what a frame says, for Info.
local function text_of_frame(item, body, words)
  local row = (item.sent or item.echo_of) and TABLES.commands[body:byte()]
  if item.doubt then
    return filled(NOT_TRUSTED, { why = DOUBTS[item.doubt] })
  elseif item.echo_of then
    return LABELS.echo .. (row and ": " .. row.name or "")
  elseif row and words and words:sub(1, #row.name) ~= row.name then
    return row.name .. ": " .. words
  end
  return words or row and row.name
end

local function show_frame(tree, item, wire, bytes)
  local body, checksum = body_of(wire, item.is_double)
  local words, asked, parts, message = meaning_of(item, body)
  local text = text_of_frame(item, body, words)
  local digits = (visible or item.doubt or not text) and hex(body) or ""
  local line = digits .. (text and "  " .. text or "")
  local branch = tree:add(F.frame, bytes, digits, line)
  local range = ranges_of(bytes, wire, #body)
  show_direction(branch, item.way)
  add(branch, F.wire, bytes)
  show_body(branch, range, body)
  if item.answers then
    show_response(branch, range, item, { body = body, parts = parts, message = message, words = words })
  elseif item.doubt then
    computed(branch, F.doubt, DOUBTS[item.doubt])
    branch:add_proto_expert_info(E.doubt, text)
  else
    show_request(branch, range, item, body, asked)
  end
  if words then
    computed(branch, F.meaning, words)
  end
  add(branch, F.checksum, bytes(#wire - 2, 1), checksum)
  show_echo(branch, item)
  if item.raw then
    computed(branch, F.raw_checksum, true)
  end
  if item.irregular then
    computed(branch, F.irregular, true)
    branch:add_proto_expert_info(E.irregular)
  end
  return branch, item.doubt and line or text or digits
end

-- Shows an item in the tree of its packet; returns its text for the column Info.
local function show(tree, tvb, item, number)
  local wire, bytes = bytes_of(item, tvb)
  local branch, text
  if item.reason then
    branch, text = show_damage(tree, item, wire, bytes)
  else
    branch, text = show_frame(tree, item, wire, bytes)
  end
  if item.first ~= number then
    computed(branch, F.begin, item.first)
  end
  if item.last ~= number then
    computed(branch, F.finish, item.last)
  end
  return text
end
