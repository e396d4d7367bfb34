-- Runs the dissector `arg[1]` without Wireshark: reads packets from stdin (`port way time bytes`; `!`
-- is a gap), and prints each frame or damage with what it says.

-- With `fields` as `arg[2]` it prints the names and descriptions of parameters instead.

-- What the dissector takes from Wireshark; it does nothing here.
local anything = {}
setmetatable(anything, {
  __index = function() return anything end,
  __call = function() return anything end,
})
for _, name in ipairs({
  "Proto", "ProtoExpert", "Pref", "Field", "DissectorTable", "base", "expert",
  "frametype", "wtap", "wtap_encaps",
}) do
  _G[name] = anything
end
FIELDS = {}
ProtoField = setmetatable({
  double = function(...)
    FIELDS[#FIELDS + 1] = table.concat({ ... }, "\t")
    return anything
  end,
}, getmetatable(anything))

-- It shares the dissector's scope.
local READER = [[
if arg[2] == "fields" then
  print(table.concat(FIELDS, "\n"))
  return
end
mikas.prefs = { interpretation = 1, baud = 9600 }
mikas.init()
for line in io.lines() do
  local name, way, time, digits = line:match("^(%S+) (%d) (%S+) (%x*)$")
  if name then
    local port = ports[name] or new_port(completed)
    ports[name] = port
    local bytes = digits:gsub("..", function(pair) return string.char(tonumber(pair, 16)) end)
    local packet = { number = #packets + 1, time = tonumber(time), bytes = bytes }
    packets[packet.number] = {}
    for _, item in ipairs(port:feed(tonumber(way), packet)) do
      follow(port, item, packet)
      if item.reason then
        print(item.reason, hex(item.wire))
      else
        local body = body_of(item.wire, item.is_double)
        print(hex(body), meaning_of(item, body) or "")
      end
    end
  else
    interrupt()
  end
end
]]

local file = assert(io.open(arg[1]))
assert(load(file:read("a") .. READER))()
