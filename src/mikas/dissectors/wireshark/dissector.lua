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

local MOST_INFO = 4096 -- bytes of the column, in Wireshark

-- By the packet's number: its frames, as `Kept` writes them; the first response to its request; the
-- packet that completes its last frame; a frame that its recording has ended in.
local kept, responses, continued, left
-- Of the present recording: ports by name; directions inside a frame, by their last packet.
local section, ports, unfinished

function mikas.init()
  kept, responses, continued, left = {}, {}, {}, {}
  section, ports, unfinished = nil, {}, {}
  forget_texts()
end

local function text_of(field)
  local found = field()
  return found and tostring(found.value) or ""
end

local function completed(number, by)
  continued[number] = by
end

-- Returns, as it is kept, the frame that a direction is inside of.
local function open_frame(direction, number)
  local writer = new_kept(number)
  writer:take(direction:unfinished(direction.packets[direction.last], function() end))
  return writer:text(0)
end

local function begin_section(number)
  for last, direction in pairs(unfinished) do
    left[last] = open_frame(direction, last)
  end
  section, ports, unfinished = number, {}, {}
end

-- Returns the port of the present packet. Two interfaces of one name and description are one port:
-- times below zero need an interface of their own. In later sections Wireshark 4.0 gives those of
-- the first one.
local function present_port()
  local number = text_of(section_number)
  if number ~= section then
    begin_section(number)
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

-- Feeds a packet to its port, keeps what it completes, and gives `see` each frame and damage. Returns
-- the number of its bytes of a frame that goes on.
local function take(port, way, number, time, bytes, see)
  local writer, direction = new_kept(number), port.directions[way]
  local before = direction.packets[direction.last]
  if before then
    unfinished[before.number] = nil
  end
  responses[number], continued[number] = nil, nil -- of a refused packet
  port:feed(way, number, time, bytes, function(item)
    writer:take(item)
    local request = item.answers
    if request then
      responses[request.number] = responses[request.number] or number
    end
    see(item)
  end)
  local open = #direction.decoder.buffer
  unfinished[number] = open > 0 and direction or nil
  open = math.min(open, #bytes)
  kept[number] = writer:text(open)
  return open
end

-- What a packet shows: its tree, and the texts for Info.
local View = {}
View.__index = View

function View:add(text)
  if self.length < MOST_INFO then
    self.texts[#self.texts + 1] = text
    self.length = self.length + #text + 3
  end
end

function View:show(item)
  if item.echo_of then
    self.has_echo = true
  else
    self.has_other = true
  end
  self:add(show(self.tree, self.tvb, item, self.number))
end

-- Shows the bytes of a frame that goes on in other packets.
function View:show_open(count)
  local tvb = self.tvb
  local bytes = tvb(tvb:len() - count, count)
  add(self.tree, F.part, bytes)
  if continued[self.number] then
    computed(self.tree, F.continued, continued[self.number])
  end
  self:add(hex(bytes:raw()) .. " …")
end

-- Shows what is kept of the packet. Its last request is the one that responses may be to.
function View:show_kept(way)
  local reader, open = new_reader(kept[self.number], self.number, way)
  local item = reader:next()
  while item do
    local following = reader:next()
    item.response = not following and responses[self.number] or nil
    self:show(item)
    item = following
  end
  local ended = left[self.number]
  if unfinished[self.number] then
    ended = open_frame(unfinished[self.number], self.number)
  end
  if ended then
    self:show(new_reader(ended, self.number, way):next())
  elseif open > 0 then
    self:show_open(open)
  end
end

function View:show_new(pinfo, way)
  local tvb, port = self.tvb, present_port()
  if not way or tvb:len() < tvb:reported_len() then
    interrupt()
  end
  if way then
    -- Microseconds, as recorded: the exact times decide over a silence.
    local time = microseconds(pinfo.abs_ts) / 1e6
    local open = take(port, way, self.number, time, tvb:raw(), function(item)
      self:show(item)
    end)
    if open > 0 then
      self:show_open(open)
    end
  end
end

function View:fill(pinfo, way)
  local columns, sent = pinfo.cols, way == SENT
  local only_echo = self.has_echo and not self.has_other
  columns.protocol = "Mikas"
  columns.src = sent and LABELS.tester or only_echo and LABELS.echo or LABELS.unit
  columns.dst = sent and LABELS.unit or LABELS.tester
  columns.info = self.length > 0 and table.concat(self.texts, " | ") or LABELS.noise
end

function mikas.dissector(tvb, pinfo, root)
  local tree, way = root:add(mikas, tvb()), FROM_SYSTEM[pinfo.p2p_dir]
  local view = setmetatable(
    { tree = tree, tvb = tvb, number = pinfo.number, texts = {}, length = 0 }, View)
  visible = root.visible
  -- A read filter gives the number of a packet that it refuses to the next one.
  if not (pinfo.visited and kept[pinfo.number]) then
    view:show_new(pinfo, way)
  else
    view:show_kept(way)
  end
  if not way then
    tree:add_proto_expert_info(E.no_direction)
    view:add(LABELS.expert_no_direction)
  elseif tvb:len() < tvb:reported_len() then
    tree:add_proto_expert_info(E.cut)
  end
  view:fill(pinfo, way)
  return tvb:len()
end

-- Recordings have link type USER0 (147): with this, no preference has to be set.
DissectorTable.get("wtap_encap"):add((wtap_encaps or wtap).USER0, mikas)
