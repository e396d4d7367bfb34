-- What Wireshark knows of the protocol beforehand: fields, expert infos, preferences.
--
-- A value's field is `mikas.param.NAME`, a number with its unit in the name, or a boolean:
-- `mikas.param.TWAT > 90`, `mikas.param.DET == 1`. A field that says yes is there only then:
-- `mikas.echo`, `not mikas.echo`.

local mikas = Proto("mikas", LABELS.protocol)

local function names_of(rows, key)
  local names = {}
  for code, row in pairs(rows) do
    names[code] = key and row[key] or row
  end
  return names
end

local function codes_with_names()
  local names = {}
  for _, row in ipairs(TABLES.parameters) do
    names[row.code] = names[row.code] and names[row.code] .. "/" .. row.name or row.name
  end
  return names
end

local COMMAND_NAMES = names_of(TABLES.commands, "name")
local CODE_NAMES = codes_with_names()
local FAULT_TEXTS = names_of(TABLES.faults, "text")
local RESULTS = { [0] = TABLES.messages.done, [1] = TABLES.messages.refused }

local F = {
  frame = ProtoField.string("mikas.frame", LABELS.frame),
  direction = ProtoField.string("mikas.direction", LABELS.direction),
  echo = ProtoField.bool("mikas.echo", LABELS.echo),
  echo_of = ProtoField.framenum("mikas.echo_of", LABELS.echo_of),
  wire = ProtoField.bytes("mikas.wire", LABELS.wire, base.SPACE),
  body = ProtoField.bytes("mikas.body", LABELS.body, base.SPACE),
  checksum = ProtoField.uint8("mikas.checksum", LABELS.checksum, base.HEX),
  raw_checksum = ProtoField.bool("mikas.raw_checksum", LABELS.raw_checksum),
  irregular = ProtoField.bool("mikas.irregular", LABELS.irregular),
  begin = ProtoField.framenum("mikas.begin", LABELS.begin),
  finish = ProtoField.framenum("mikas.end", LABELS.finish),
  continued = ProtoField.framenum("mikas.continued", LABELS.continued),
  part = ProtoField.bytes("mikas.part", LABELS.part, base.SPACE),
  damage = ProtoField.string("mikas.damage", LABELS.damage),
  damage_data = ProtoField.bytes("mikas.damage.data", LABELS.damage_data, base.SPACE),
  command = ProtoField.uint8("mikas.command", LABELS.command, base.HEX, COMMAND_NAMES),
  name = ProtoField.string("mikas.name", LABELS.name),
  meaning = ProtoField.string("mikas.meaning", LABELS.meaning),
  request = ProtoField.string("mikas.request", LABELS.request),
  doubt = ProtoField.string("mikas.doubt", LABELS.doubt),
  request_in = ProtoField.framenum("mikas.request_in", LABELS.request_in, base.NONE,
    frametype.REQUEST),
  response_in = ProtoField.framenum("mikas.response_in", LABELS.response_in, base.NONE,
    frametype.RESPONSE),
  response_time = ProtoField.relative_time("mikas.response_time", LABELS.response_time),
  interval = ProtoField.relative_time("mikas.interval", LABELS.interval),
  address = ProtoField.uint16("mikas.address", LABELS.address, base.HEX),
  count = ProtoField.uint8("mikas.count", LABELS.count),
  value = ProtoField.uint8("mikas.value", LABELS.value, base.HEX),
  data = ProtoField.bytes("mikas.data", LABELS.data, base.SPACE),
  code = ProtoField.uint8("mikas.code", LABELS.code, base.HEX, CODE_NAMES),
  model = ProtoField.uint8("mikas.model", LABELS.model, base.HEX, TABLES.models),
  fault_count = ProtoField.uint8("mikas.fault.count", LABELS.fault_count),
  fault = ProtoField.uint8("mikas.fault", LABELS.fault, base.DEC, FAULT_TEXTS),
  passport = ProtoField.string("mikas.passport", LABELS.passport),
  result = ProtoField.uint8("mikas.result", LABELS.result, base.HEX, RESULTS),
}

local all_fields = {}
for _, field in pairs(F) do
  all_fields[#all_fields + 1] = field
end

-- Returns the field of a parameter. Its unit, and the errata in its description, are those of the
-- interpretation with which this file was made: a preference can't rename a field.
local function field_of(row)
  local conversion, is_flag = row.interpretations[INTERPRETATION], true
  for _, each in pairs(row.interpretations) do
    is_flag = is_flag and each.mask ~= 0
  end
  local name = row.text .. (conversion.unit ~= "" and ", " .. conversion.unit or "")
  local about = { name }
  for _, erratum in ipairs(row.errata) do
    about[#about + 1] = erratum .. ": " .. TABLES.errata[erratum][INTERPRETATION]
  end
  local abbreviation, description = "mikas.param." .. row.name, table.concat(about, ". ")
  if is_flag then
    return ProtoField.bool(abbreviation, name, base.NONE, nil, 0, description), true
  end
  return ProtoField.double(abbreviation, name, description), false
end

local PARAMETERS, IS_FLAG = {}, {} -- by name
for _, row in ipairs(TABLES.parameters) do
  PARAMETERS[row.name], IS_FLAG[row.name] = field_of(row)
  all_fields[#all_fields + 1] = PARAMETERS[row.name]
end
mikas.fields = all_fields

local function expert_info(name, group, severity)
  return ProtoExpert.new("mikas.expert." .. name, LABELS["expert_" .. name], group, severity)
end

local E = {
  checksum = expert_info("checksum", expert.group.CHECKSUM, expert.severity.ERROR),
  too_long = expert_info("too_long", expert.group.MALFORMED, expert.severity.ERROR),
  unfinished = expert_info("unfinished", expert.group.REASSEMBLE, expert.severity.WARN),
  irregular = expert_info("irregular", expert.group.PROTOCOL, expert.severity.NOTE),
  unfit = expert_info("unfit", expert.group.RESPONSE_CODE, expert.severity.WARN),
  refused = expert_info("refused", expert.group.RESPONSE_CODE, expert.severity.NOTE),
  doubt = expert_info("doubt", expert.group.SEQUENCE, expert.severity.WARN),
  unknown = expert_info("unknown", expert.group.UNDECODED, expert.severity.NOTE),
  fault = expert_info("fault", expert.group.RESPONSE_CODE, expert.severity.NOTE),
  no_direction = expert_info("no_direction", expert.group.ASSUMPTION, expert.severity.WARN),
  cut = expert_info("cut", expert.group.MALFORMED, expert.severity.WARN),
}
local all_experts = {}
for _, each in pairs(E) do
  all_experts[#all_experts + 1] = each
end
mikas.experts = all_experts

local INTERPRETATIONS = { "corrected", "literal", "alternative", "family" }
local choices = {}
for index, name in ipairs(INTERPRETATIONS) do
  choices[index] = { index, name, index }
  if name == INTERPRETATION then
    INTERPRETATION = index
  end
end
mikas.prefs.interpretation = Pref.enum(
  LABELS.interpretation, INTERPRETATION, LABELS.interpretation_help, choices, false)
mikas.prefs.baud = Pref.uint(LABELS.baud, 9600, LABELS.baud_help)

local function interpretation()
  return INTERPRETATIONS[mikas.prefs.interpretation]
end

-- Returns the seconds of a byte on the wire: ten bits.
local function byte_time()
  local baud = mikas.prefs.baud
  return 10 / (baud > 0 and baud or 9600)
end
