// The kept files as a folder of Emscripten's: Python's open, os.replace, os.fsync, scandir work there.
//
// Folders are in memory: there is one if a file is below it, or `mkdir` made it since the start.
// A folder is not renamed (EXDEV, so that shutil copies), and there are no links.

import { errno, FileError } from "./errors";
import { Pool } from "./pool";
import type { KeptFile } from "./slot";
import type { PoolView } from "./view";

/** What is used of Emscripten's FS, for which there are no types. */
export interface EmscriptenFs {
  FSNode: new (parent: Node | null, name: string, mode: number, device: number) => Node;
  isDir(mode: number): boolean;
  mkdirTree(path: string): void;
  mount(type: object, options: object, path: string): unknown;
  hashRemoveNode(node: Node): void;
  closeStream(descriptor: number): void;
}

interface Node {
  id: number;
  name: string;
  mode: number;
  parent: Node;
  mtime: number;
  node_ops: object;
  stream_ops: object;
  /** Of a folder: what is in it. */
  entries?: Map<string, Node>;
  /** Of a file. */
  file?: KeptFile;
}

interface Stream {
  fd: number;
  node: Node;
  flags: number;
  position: number;
}

interface Attributes {
  mode?: number;
  size?: number;
  mtime?: number | null;
}

const FOLDER = 0o040777;
const FILE = 0o100666;
const ACCESS = 3; // the bits of the flags that say how a file is opened: 0 to read only
const DEVICE = 0x6b657074;
const BLOCK = 512;
const FOLDERS = 2 ** 40; // above the ids of files

/** Mount the files at `path`, which is made. */
export function mount(fs: EmscriptenFs, path: string, files: Pool | PoolView): void {
  const kept = new Mount(fs, files);
  fs.mkdirTree(path);
  fs.mount({ mount: () => kept.root }, {}, path);
  kept.fill(); // not before the root knows its mount, which all nodes take from it
}

class Mount {
  readonly root: Node;

  constructor(
    private readonly fs: EmscriptenFs,
    private readonly files: Pool | PoolView,
  ) {
    this.root = this.#folder(null, "/");
    if (!(files instanceof Pool)) files.onChange = () => this.fill();
  }

  /** The pool, if it can be changed. */
  get #pool(): Pool {
    if (this.files instanceof Pool) return this.files;
    throw new FileError(errno.ROFS);
  }

  /** Have the nodes of all files. Nodes of before serve who has them open. */
  fill(): void {
    this.root.entries!.clear();
    const path = (file: KeptFile) => file.path!;
    // A file comes before those below a folder of its name, which a power failure may leave.
    const files = [...this.files.all()].sort((one, other) => (path(one) < path(other) ? -1 : 1));
    for (const file of files) {
      const names = path(file).split("/");
      const last = names.pop()!;
      this.#file(
        names.reduce((folder, name) => this.#folderIn(folder, name), this.root),
        last,
        file,
      );
    }
  }

  /** Return the folder of that name, or of `name~` if there is a file of that name. */
  #folderIn(parent: Node, name: string): Node {
    const node = parent.entries!.get(name);
    if (node?.file) return this.#folderIn(parent, `${name}~`);
    return node ?? this.#folder(parent, name);
  }

  // Not by FS.createNode: Emscripten would remember nodes by name, and a view's names change.
  #node(parent: Node | null, name: string, mode: number): Node {
    const node = new this.fs.FSNode(parent, name, mode, 0);
    node.node_ops = this.#nodeOps;
    parent?.entries!.set(name, node);
    return node;
  }

  #folder(parent: Node | null, name: string): Node {
    const node = this.#node(parent, name, FOLDER);
    node.entries = new Map();
    node.stream_ops = this.#folderOps;
    return node;
  }

  #file(parent: Node, name: string, file: KeptFile): Node {
    const node = this.#node(parent, name, FILE);
    node.id = file.id;
    node.file = file;
    node.stream_ops = this.#fileOps;
    return node;
  }

  #path(folder: Node, name: string): string {
    let path = name;
    for (let node = folder; node !== this.root; node = node.parent) path = `${node.name}/${path}`;
    return path;
  }

  readonly #nodeOps = {
    getattr: (node: Node) => {
      const { file } = node;
      const size = file?.size ?? 0;
      const time = new Date(file?.mtime ?? node.mtime);
      return {
        dev: DEVICE,
        ino: file?.id ?? FOLDERS + node.id,
        mode: node.mode,
        nlink: file?.path === null ? 0 : 1,
        uid: 0,
        gid: 0,
        rdev: 0,
        size,
        atime: time,
        mtime: time,
        ctime: time,
        blksize: 4096,
        blocks: Math.ceil(size / BLOCK),
      };
    },

    setattr: (node: Node, { mode, size, mtime }: Attributes) => {
      const pool = this.#pool;
      const { file } = node;
      if (mode !== undefined) node.mode = mode;
      if (file && size !== undefined) pool.truncate(file, size);
      if (file && typeof mtime === "number") pool.touch(file, mtime);
    },

    lookup: (folder: Node, name: string) => {
      const node = folder.entries!.get(name);
      if (node) return node;
      throw new FileError(errno.NOENT);
    },

    mknod: (folder: Node, name: string, mode: number) => {
      const pool = this.#pool;
      if (this.fs.isDir(mode)) return this.#folder(folder, name);
      return this.#file(folder, name, pool.create(this.#path(folder, name)));
    },

    rename: (node: Node, folder: Node, name: string) => {
      const pool = this.#pool;
      if (!node.file) throw new FileError(errno.XDEV);
      const replaced = folder.entries!.get(name);
      pool.rename(node.file, this.#path(folder, name), replaced?.file ?? null);
      if (replaced) this.fs.hashRemoveNode(replaced); // it was renamed itself before
      node.parent.entries!.delete(node.name);
      node.name = name;
      node.parent = folder;
      folder.entries!.set(name, node);
    },

    unlink: (folder: Node, name: string) => {
      this.#pool.remove(folder.entries!.get(name)!.file!);
      folder.entries!.delete(name);
    },

    rmdir: (folder: Node, name: string) => {
      void this.#pool;
      if (folder.entries!.get(name)!.entries!.size) throw new FileError(errno.NOTEMPTY);
      folder.entries!.delete(name);
    },

    readdir: (folder: Node) => [".", "..", ...folder.entries!.keys()],
  };

  readonly #folderOps = { llseek: (stream: Stream, offset: number, whence: number) => seek(stream, offset, whence, 0) };

  readonly #fileOps = {
    open: (stream: Stream) => {
      try {
        if (stream.flags & ACCESS) void this.#pool;
      } catch (error) {
        this.fs.closeStream(stream.fd); // Emscripten leaves it open
        throw error;
      }
      this.#hold(stream);
    },
    dup: (stream: Stream) => this.#hold(stream),
    close: ({ node }: Stream) => {
      if (this.files instanceof Pool) this.files.letGo(node.file!);
    },
    llseek: (stream: Stream, offset: number, whence: number) => seek(stream, offset, whence, stream.node.file!.size),
    read: ({ node }: Stream, memory: ArrayBufferView, offset: number, length: number, at: number) =>
      node.file!.read(bytesOf(memory, offset, length), at),
    write: ({ node }: Stream, memory: ArrayBufferView, offset: number, length: number, at: number) =>
      this.#pool.write(node.file!, bytesOf(memory, offset, length), at),
    fsync: ({ node }: Stream) => {
      if (this.files instanceof Pool) this.files.flush(node.file!);
      return 0;
    },
  };

  #hold({ node }: Stream): void {
    if (this.files instanceof Pool) this.files.hold(node.file!);
  }
}

function bytesOf(memory: ArrayBufferView, offset: number, length: number): Uint8Array {
  return new Uint8Array(memory.buffer, memory.byteOffset + offset, length);
}

function seek(stream: Stream, offset: number, whence: number, size: number): number {
  const position = offset + [0, stream.position, size][whence]!;
  if (position < 0) throw new FileError(errno.INVAL);
  return position;
}
