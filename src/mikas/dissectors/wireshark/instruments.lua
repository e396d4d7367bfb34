-- Instruments beside the unit: what each has sent, by its name. Their packets are chunks, too, so a
-- line that goes on in the next packet is shown in the one with its end. Values are not computed:
-- `mikas decode` has them.

local beside = Proto("mikas_instrument", "Mikas, " .. LABELS.instrument)
local BESIDE = {
  name = ProtoField.string("mikas_instrument.name", LABELS.instrument),
  line = ProtoField.string("mikas_instrument.line", LABELS.instrument_line),
  bytes = ProtoField.bytes("mikas_instrument.bytes", LABELS.instrument_bytes, base.SPACE),
}
beside.fields = { BESIDE.name, BESIDE.line, BESIDE.bytes }

local packet_comment = optional_field("frame.comment")
local MOST_OPEN = 256 -- bytes of a line, as of `mikas`

-- By the packet's number: the lines that end in it, nil of bytes that are no text. By the port: the
-- begin of a line that is not complete.
local lines_of, open_line

function beside.init()
  lines_of, open_line = {}, {}
end

-- Returns `left:aem`. Wireshark 4.0 gives later sections the descriptions of the first one.
local function instrument_name()
  local number = text_of(section_number)
  local name = (number == "1" or number == "") and text_of(interface_description):match("^[^,]+")
  return name or "#" .. text_of(interface_id)
end

-- Returns the lines that end in these bytes of a port; nil if they are no text.
local function lines_that_end(port, bytes)
  local all = (open_line[port] or "") .. bytes
  if all:find("[^\t\r\n\032-\126]") then
    open_line[port] = nil
    return nil
  end
  local lines = {}
  for line in all:gmatch("([^\r\n]+)[\r\n]") do
    lines[#lines + 1] = line
  end
  local rest = all:match("[^\r\n]*$")
  open_line[port] = #rest <= MOST_OPEN and rest or nil
  return lines
end

function beside.dissector(tvb, pinfo, root)
  local tree, name = root:add(beside, tvb()), instrument_name()
  local bytes = tvb:len() > 0 and tvb():raw() or ""
  if not pinfo.visited then
    local port = text_of(section_number) .. "\n" .. text_of(interface_id)
    if bytes == "" then -- the connection began, or was lost
      open_line[port] = nil
    end
    lines_of[pinfo.number] = lines_that_end(port, bytes)
  end
  tree:add(BESIDE.name, name)
  local texts, lines = {}, lines_of[pinfo.number]
  if bytes == "" then
    texts[1] = text_of(packet_comment):gsub("\n.*", "")
  elseif lines then
    for _, line in ipairs(lines) do
      tree:add(BESIDE.line, line)
      texts[#texts + 1] = line
    end
    if #lines == 0 then
      texts[1] = LABELS.instrument_unfinished
    end
  else
    texts[1] = hex(bytes)
  end
  if bytes ~= "" then
    tree:add(BESIDE.bytes, tvb())
  end
  pinfo.cols.protocol = "Mikas"
  pinfo.cols.src = name
  pinfo.cols.dst = LABELS.tester
  pinfo.cols.info = LABELS.instrument .. " " .. name .. ": " .. table.concat(texts, " | ")
  return tvb:len()
end

-- Their interfaces have link type USER1 (148).
DissectorTable.get("wtap_encap"):add((wtap_encaps or wtap).USER1, beside)
