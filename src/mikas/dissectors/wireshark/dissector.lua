-- Packets. The first pass, in the order of the file, feeds the decoders; what it finds is kept by
-- the packet's number, and every later pass, in any order, shows that. Each section of a file is a
-- recording of its own.

local FROM_SYSTEM = { [0] = SENT, [1] = RECEIVED } -- pinfo.p2p_dir

local function optional_field(name)
  local exists, field = pcall(Field.new, name)
  return exists and field or function() end -- an older Wireshark lacks some
end

local section_number = optional_field("frame.section_number")
local interface_id = optional_field("frame.interface_id")
local interface_name = optional_field("frame.interface_name")
local interface_description = optional_field("frame.interface_description")

local KEPT = {
  "reason", "sent", "echo_of", "answers", "listed", "is_first", "since", "raw", "irregular",
  "is_double",
}

local packets, ports, section -- by number; by name; the present one

function mikas.init()
  packets, ports, section = {}, {}, nil
end

local function text_of(field)
  local found = field()
  return found and tostring(found.value) or ""
end

local function completed(number, by)
  packets[number].continued = by
end

-- Returns the port of the present packet. Two interfaces of one name and description are one port:
-- times below zero need an interface of their own. In later sections Wireshark 4.0 gives those of
-- the first one.
local function present_port()
  local number = text_of(section_number)
  if number ~= section then
    section, ports = number, {}
  end
  local is_first = number == "1" or number == ""
  local name = is_first and text_of(interface_name) .. "\n" .. text_of(interface_description)
    or text_of(interface_id)
  ports[name] = ports[name] or new_port(completed)
  return ports[name]
end

local function interrupt()
  for _, port in pairs(ports) do
    port.matching:interrupt()
  end
end

-- Completes an item of the first pass by what its meaning needs.
local function follow(port, item, packet)
  if item.reason or item.echo_of then
    return
  elseif item.sent then
    item.listed = port.following:take(item.body)
    return
  end
  local request = item.answers
  if request.body then
    item.listed, item.is_first = port.following:take(request.body, item.body)
    local row = TABLES.commands[request.body:byte()]
    if row and row.stream and request.latest then
      item.since = packet.time - request.latest
    end
  end
  if request.number then
    request.response = request.response or packet.number
    request.latest = packet.time
  end
end

-- Returns the item as it is kept: without what is in the packet, or can be computed again.
local function kept(item, number)
  local small = { way = item.way, at = item.at, length = #item.wire }
  for _, name in ipairs(KEPT) do
    small[name] = item[name] or nil
  end
  small.wire = not item.at and item.wire or nil
  small.first = item.first ~= number and item.first or nil
  small.last = item.last ~= number and item.last or nil
  return small
end

local function first_pass(tvb, pinfo, time)
  local port, way = present_port(), FROM_SYSTEM[pinfo.p2p_dir]
  local found = { port = port, way = way, items = {} }
  packets[pinfo.number] = found
  if not way or tvb:len() < tvb:reported_len() then
    interrupt()
  end
  if way then
    local packet = { number = pinfo.number, time = time, bytes = tvb:raw() }
    for index, item in ipairs(port:feed(way, packet)) do
      follow(port, item, packet)
      found.items[index] = kept(item, packet.number)
    end
    local decoder = port.directions[way].decoder
    found.open = math.min(#decoder.buffer, #packet.bytes)
  end
  return found
end

-- Returns a frame that the recording ends in, if this packet has the last of its bytes.
local function left_open(found, number)
  local direction = found.way and found.port.directions[found.way]
  local last = direction and direction.packets[direction.last]
  if last and last.number == number then
    local item = direction:unfinished(last, function() end)
    return item and kept(item, number)
  end
end

-- Shows the bytes of a frame that goes on in other packets; returns the text for Info.
local function show_open(tree, tvb, found)
  local bytes = tvb(tvb:len() - found.open, found.open)
  add(tree, F.part, bytes)
  if found.continued then
    computed(tree, F.continued, found.continued)
  end
  return hex(bytes:raw()) .. " …"
end

local function columns(pinfo, found, texts)
  local echoes, others = 0, 0
  for _, item in ipairs(found.items) do
    if item.echo_of then
      echoes = echoes + 1
    else
      others = others + 1
    end
  end
  local sent = found.way == SENT
  local only_echo = echoes > 0 and others == 0
  pinfo.cols.protocol = "Mikas"
  pinfo.cols.src = sent and LABELS.tester or only_echo and LABELS.echo or LABELS.unit
  pinfo.cols.dst = sent and LABELS.unit or LABELS.tester
  pinfo.cols.info = #texts > 0 and table.concat(texts, " | ") or LABELS.noise
end

function mikas.dissector(tvb, pinfo, root)
  -- Microseconds, as recorded: the exact times decide over a silence.
  local time = math.floor(pinfo.abs_ts * 1e6 + 0.5) / 1e6
  -- A read filter gives the number of a packet that it refuses to the next one.
  local found = pinfo.visited and packets[pinfo.number] or first_pass(tvb, pinfo, time)
  local tree, texts = root:add(mikas, tvb()), {}
  visible = root.visible
  for _, item in ipairs(found.items) do
    texts[#texts + 1] = show(tree, tvb, item, pinfo.number, time)
  end
  local left = pinfo.visited and left_open(found, pinfo.number)
  if left then
    texts[#texts + 1] = show(tree, tvb, left, pinfo.number, time)
  elseif found.open and found.open > 0 then
    texts[#texts + 1] = show_open(tree, tvb, found)
  end
  if not found.way then
    tree:add_proto_expert_info(E.no_direction)
    texts[1] = LABELS.expert_no_direction
  elseif tvb:len() < tvb:reported_len() then
    tree:add_proto_expert_info(E.cut)
  end
  columns(pinfo, found, texts)
  return tvb:len()
end

-- Recordings have link type USER0 (147): with this, no preference has to be set.
DissectorTable.get("wtap_encap"):add((wtap_encaps or wtap).USER0, mikas)
