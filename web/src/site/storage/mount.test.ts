// Python of Pyodide on the mounted pool. One Pyodide for all: its start takes a second or two.

import { loadPyodide } from "pyodide";
import { beforeAll, beforeEach, expect, test } from "vitest";
import { fileURLToPath } from "node:url";
import { FakeDisk } from "../../../test/fakeDisk";
import { type EmscriptenFs, mount } from "./mount";
import { Pool } from "./pool";
import { PoolView } from "./view";

const SOURCE = fileURLToPath(new URL("../../../../src/", import.meta.url));

let python: Awaited<ReturnType<typeof loadPyodide>>;
let disk: FakeDisk;
let pool: Pool;
let mounts = 0;
let now = 0;

/** Run Python with `kept`, the path of the mounted files; return what its last line is. */
async function run(code: string): Promise<unknown> {
  const value: unknown = await python.runPythonAsync(code);
  return value;
}

function mounted(files: Pool | PoolView): string {
  const path = `/kept${++mounts}`;
  mount(python.FS as unknown as EmscriptenFs, path, files);
  return path;
}

/** As after a reload of the page: the same disk, opened again. */
async function reload(): Promise<void> {
  pool.close();
  pool = await Pool.open(disk, () => now);
  python.globals.set("kept", mounted(pool));
}

beforeAll(async () => {
  python = await loadPyodide();
  python.mountNodeFS("/source", SOURCE);
  await run(`
import errno, os, stat, sys
from pathlib import Path
sys.path.insert(0, "/source")
sys.dont_write_bytecode = True

def refused(call, *arguments, **named):
    try:
        call(*arguments, **named)
    except OSError as error:
        return errno.errorcode[error.errno]

# Importing takes longest: here, where it has the time.
import importlib.metadata
importlib.metadata.version = lambda name: "0"
from mikas.dashboard.library.folder import RecordingFolder, opened
from mikas.errors import CaptureError
from mikas.link.base import Direction
from mikas.recording.capture.reader import CaptureReader
from mikas.recording.capture.writer import CaptureWriter
from mikas.saving import KeptFile, append_line, save, write_all
`);
}, 120_000);

beforeEach(async () => {
  disk = new FakeDisk();
  now = 1_700_000_000_123;
  pool = await Pool.open(disk, () => now);
  python.globals.set("kept", mounted(pool));
});

test("a file is made, appended to, cut, read, and there after a reload", async () => {
  await run(`
folder = Path(kept) / "a" / "b"
folder.mkdir(parents=True)
with (folder / "x").open("xb", buffering=0) as file:
    assert file.write(b"0123456789") == 10
    file.truncate(4)
    file.seek(4)
    file.write(b"abc")
    os.fsync(file.fileno())
with (folder / "x").open("a+b", buffering=0) as file:
    file.write(b"d")
    file.seek(1)
    assert file.read(2) == b"12"
    file.write(b"e")
with (folder / "x").open("r+b", buffering=0) as file:
    file.write(b"X")
assert refused((folder / "x").open, "xb") == "EEXIST"
`);
  await reload();
  expect(await run(`(Path(kept) / "a" / "b" / "x").read_text() + " " + " ".join(os.listdir(kept))`)).toBe("X123abcde a");
});

test("stat says size, time, one name; none after it was deleted while open", async () => {
  now = 1_700_000_000_456;
  await run(`
path = Path(kept) / "x"
file = path.open("xb", buffering=0)
file.write(b"abc")
status = os.fstat(file.fileno())
assert (status.st_size, status.st_nlink, status.st_mtime_ns) == (3, 1, 1_700_000_000_456_000_000)
assert stat.S_ISREG(status.st_mode)
(Path(kept) / "y").touch(0o600, exist_ok=False)
assert path.lstat().st_ino == status.st_ino != (Path(kept) / "y").stat().st_ino
assert os.path.samestat(status, path.stat())
path.unlink()
assert os.fstat(file.fileno()).st_nlink == 0
assert not os.path.lexists(path)
file.write(b"def")
assert os.fstat(file.fileno()).st_size == 6
file.close()
(entry,) = os.scandir(kept)
assert (entry.name, entry.is_file(), entry.stat().st_size) == ("y", True, 0)
`);
  expect([...pool.all()].map(({ size }) => size)).toEqual([0]);
});

test("a time that was set, and the number of a file, survive", async () => {
  const before = await run(`
path = Path(kept) / "x"
path.write_text("abc")
os.utime(path, (5, 7.25))
str((path.stat().st_mtime_ns, path.stat().st_ino))
`);
  await reload();
  expect(await run(`str(((Path(kept) / "x").stat().st_mtime_ns, (Path(kept) / "x").stat().st_ino))`)).toBe(before);
});

test("folders and names are as elsewhere", async () => {
  await run(`
top = Path(kept)
(top / "a" / "b").mkdir(parents=True, exist_ok=True)
(top / "a" / "b").mkdir(parents=True, exist_ok=True)
(top / "a" / "f").write_bytes(b"1")
assert refused(top.joinpath("a").rmdir) == "ENOTEMPTY"
assert refused(top.joinpath("a").unlink) == "EISDIR"
assert refused(top.joinpath("a", "f", "g").write_bytes, b"") == "ENOTDIR"
assert refused(top.joinpath("no", "g").write_bytes, b"") == "ENOENT"
assert refused(top.joinpath("a").rename, top / "c") == "EXDEV"
assert refused(os.symlink, "x", top / "link") == "EPERM"
assert refused(top.joinpath("я" * 128).touch) == "ENAMETOOLONG"
(top / ("я" * 127)).touch()
assert "я" * 127 in os.listdir(top)
(top / "a" / "b").rmdir()
assert sorted(str(path.relative_to(top)) for path in top.rglob("*")) == ["a", "a/f", "я" * 127]
(top / "a" / "f").replace(top / "g")
(top / "h").write_bytes(b"2")
os.replace(top / "h", top / "g")
os.replace(top / "g", top / "h")
os.replace(top / "h", top / "g")
assert (top / "g").read_bytes() == b"2" and not (top / "h").exists()
folder = os.open(top, os.O_RDONLY)
os.fsync(folder)
os.close(folder)
import shutil
shutil.rmtree(top / "a")
assert sorted(os.listdir(top)) == ["g", "я" * 127]
`);
});

test("a descriptor that was duplicated keeps a deleted file", async () => {
  await run(`
path = Path(kept) / "x"
first = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW | os.O_NONBLOCK)
second = os.dup(first)
path.unlink()
os.close(first)
for number in range(40):  # no slot is taken away from it
    (Path(kept) / "y").write_bytes(b"y" * 100)
    (Path(kept) / "y").unlink()
os.write(second, b"abc")
assert os.pread(second, 9, 0) == b"abc"
os.close(second)
`);
});

test("a file and a folder of one name are both there", async () => {
  for (const path of ["a", "a/b", "a/c", "a.", "b/c"]) pool.write(pool.create(path), new Uint8Array(1), 0);
  await reload();
  await run(`
top = Path(kept)
assert sorted(str(path.relative_to(top)) for path in top.rglob("*")) == ["a", "a.", "a~", "a~/b", "a~/c", "b", "b/c"]
(top / "a").unlink()
(top / "a~" / "b").rename(top / "d")
`);
  await reload();
  expect(await run(`" ".join(sorted(os.listdir(kept)))`)).toBe("a a. b d");
});

test("a full disk is ENOSPC, and what was written is there", async () => {
  for (const full of ["short", "throws", "number"] as const) {
    disk.full = full;
    python.globals.set("name", full);
    await run(`
path = Path(kept) / name
file = path.open("xb", buffering=0)
file.write(b"0123")
`);
    disk.room = disk.used + 3;
    await run(`
assert refused(write_all, file, b"456789") == "ENOSPC"
assert os.fstat(file.fileno()).st_size in (4, 7)
file.truncate(4)
file.seek(4)
assert refused(file.truncate, 100) == "ENOSPC"
file.close()
assert path.read_bytes() == b"0123"
assert refused(save, path, "the new content") == "ENOSPC"
assert path.read_bytes() == b"0123" and os.listdir(kept) == [name]
path.unlink()
`);
    disk.room = Infinity;
  }
});

test("without a free slot nothing is lost, and a moment later there are more", async () => {
  await run(`
made = 0
try:
    while True:
        (Path(kept) / str(made)).write_bytes(b"%d" % made)
        made += 1
except OSError as error:
    assert error.errno == errno.ENFILE
assert made >= 32
assert all((Path(kept) / str(n)).read_bytes() == b"%d" % n for n in range(made))
`);
  await pool.grown();
  await run(`
for n in range(made, made + 16):
    (Path(kept) / str(n)).write_bytes(b"%d" % n)
`);
});

test("mikas saves: replaced whole, set aside when damaged, lines appended", async () => {
  now += 5000;
  await run(`
path = Path(kept) / "settings" / "a.json"
file = KeptFile(path, 1000, dict)
assert file.load() is None
file.save({"a": 1})
file.save({"a": 2})
assert file.load() == {"a": 2} and os.listdir(path.parent) == ["a.json"]
path.write_text("not JSON")
file.save({"a": 3})
append_line(Path(kept) / "journal", "one")
append_line(Path(kept) / "journal", "two")
save(Path(kept) / "private", "secret", private=True)
`);
  await reload();
  await run(`
folder = Path(kept) / "settings"
assert sorted(os.listdir(folder)) == ["a.json", "a.json.broken"]
assert KeptFile(folder / "a.json", 1000, dict).load() == {"a": 3}
assert (Path(kept) / "journal").read_text() == "one\\ntwo\\n"
`);
});

test("mikas records: the file is read while it grows, a deleted one is noticed", async () => {
  await run(`
folder = Path(kept) / "recordings"
folder.mkdir()
path = folder / "r.pcapng"
writer = CaptureWriter(path, url="webserial:", pipe=False)
for n in range(100):
    writer.record(Direction.RECEIVED, b"%04d" % n, 1_700_000_000 + n / 50)
assert len(list(CaptureReader(path))) == 100
writer.close()
gone = CaptureWriter(folder / "gone.pcapng", url="webserial:", pipe=False)
(folder / "gone.pcapng").unlink()
try:
    gone.record(Direction.RECEIVED, b"x", 1_700_000_010)
except CaptureError:
    assert gone.deleted
else:
    assert False
gone.close()
`);
  await reload();
  await run(`
recordings = RecordingFolder(Path(kept) / "recordings")
(file,) = recordings.all().files
assert file.id == "r.pcapng" and file.bytes == file.path.stat().st_size
with opened(file.path, file.id) as kept_file:
    assert len(kept_file.read()) == file.bytes
`);
});

test("a view reads what the pool writes, and changes nothing", async () => {
  await run(`
(Path(kept) / "a").mkdir()
writer = (Path(kept) / "a" / "x").open("xb", buffering=0)
writer.write(b"one")
`);
  const view = await PoolView.open(disk);
  python.globals.set("seen", mounted(view));
  await run(`
reader = (Path(seen) / "a" / "x").open("rb", buffering=0)
assert reader.read() == b"one"
writer.write(b"two")
assert reader.read() == b"two"
assert os.fstat(reader.fileno()).st_size == 6
x = Path(seen) / "a" / "x"
assert os.path.samestat(x.stat(), os.fstat(writer.fileno())) is True
for call in (
    lambda: x.write_bytes(b""), lambda: x.open("r+b"), lambda: x.open("ab"), x.unlink, lambda: x.rename(x.with_name("y")),
    lambda: x.with_name("y").touch(), lambda: (Path(seen) / "b").mkdir(), lambda: os.utime(x), lambda: x.chmod(0o600),
    lambda: os.truncate(x, 1),
):
    assert refused(call) == "EROFS", call
first = os.open(x, os.O_RDONLY)
os.close(first)
for _ in range(5): refused(x.open, "ab")
second = os.open(x, os.O_RDONLY)
os.close(second)
assert first == second  # no descriptor was left open
(Path(kept) / "a" / "z").write_bytes(b"new")
(Path(kept) / "a" / "x").rename(Path(kept) / "y")
`);
  await view.refresh();
  await run(`
assert sorted(os.listdir(seen)) == ["a", "y"] and os.listdir(seen + "/a") == ["z"]
assert (Path(seen) / "y").read_bytes() == b"onetwo"
assert reader.read() == b""
writer.close()
(Path(kept) / "y").unlink()
reader.seek(0)
assert refused(reader.read) == "ESTALE"
reader.close()
`);
  await view.refresh();
  await run(`assert os.listdir(seen) == ["a"]`);
  view.close();
});
