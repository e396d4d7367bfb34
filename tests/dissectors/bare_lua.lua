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
  "ProtoExpert", "Pref", "Field", "DissectorTable", "base", "expert",
  "frametype", "wtap", "wtap_encaps",
}) do
  _G[name] = anything
end
-- Each protocol has its own `init` and `dissector`.
function Proto()
  return setmetatable({}, getmetatable(anything))
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
local count = 0
for line in io.lines() do
  local name, way, time, digits = line:match("^(%S+) (%d) (%S+) (%x*)$")
  if name then
    ports[name] = ports[name] or new_port(completed)
    local bytes = digits:gsub("..", function(pair) return string.char(tonumber(pair, 16)) end)
    count = count + 1
    take(ports[name], tonumber(way), count, tonumber(time), bytes, function(item)
      if arg[2] == "memory" then
        return
      elseif item.reason then
        print(item.reason, hex(item.wire), "", item.echo_of and "echo" or "")
      else
        local body = body_of(item.wire, item.is_double)
        local role = item.echo_of and "echo" or item.doubt and DOUBTS[item.doubt]
          or item.answers and hex(item.answers.body) or ""
        print(hex(body), meaning_of(item, body) or "", role)
      end
    end)
  else
    interrupt()
  end
end
if arg[2] == "memory" then
  collectgarbage()
  print(string.format("%d", collectgarbage("count") * 1024))
end
]]

local file = assert(io.open(arg[1]))
assert(load(file:read("a") .. READER))()
