// The formula of a watched cell: arithmetic on the cell's bytes, in the notation of §4. `b` is the first byte, `s` the same as a signed
// number, `w` = second·256 + first (low byte first, §2), `i` the same signed, `b2` the second byte. Numbers are decimal (`0,5` too) or
// `0x1F`; `+ − * / & ( )`. The formula is parsed into functions; eval is not used, the page's Content-Security-Policy forbids it.

export type Formula = (bytes: Uint8Array) => number | null;

export class FormulaProblem extends Error {
  constructor(
    /** Key of the message in the dictionary. */
    readonly kind: "empty" | "sign" | "end" | "name" | "long",
    readonly at: number,
    readonly found: string,
  ) {
    super(`${kind} at ${at}: ${found}`);
  }
}

interface Compiled {
  value: Formula;
  /** Bytes that the formula needs. */
  size: 1 | 2;
}

type Node = (bytes: Uint8Array) => number;

const LONGEST = 80;

interface Variable {
  size: 1 | 2;
  value: Node;
}

const VARIABLES = new Map<string, Variable>(
  Object.entries<Variable>({
    b: { size: 1, value: (d) => d[0] ?? NaN },
    s: { size: 1, value: (d) => ((d[0] ?? NaN) << 24) >> 24 },
    w: { size: 2, value: (d) => (d[1] ?? NaN) * 256 + (d[0] ?? NaN) },
    i: { size: 2, value: (d) => (((d[1] ?? 0) * 256 + (d[0] ?? 0)) << 16) >> 16 },
    b2: { size: 2, value: (d) => d[1] ?? NaN },
  }),
);

interface Token {
  text: string;
  at: number;
}

function tokens(text: string): Token[] {
  const found = [...text.matchAll(/0x[0-9a-f]+|\d+(?:[.,]\d+)?|[a-z_]\w*|\S/gi)];
  return found.map(({ 0: text, index: at }) => {
    if (!/^[\w\-+*/&()−·×]/.test(text)) throw new FormulaProblem("sign", at, text);
    return { text, at };
  });
}

interface Operator {
  /** From 0, which binds weakest. */
  level: number;
  of: (a: number, b: number) => number;
}

const OPERATORS = new Map<string, Operator>([
  ["&", { level: 0, of: (a, b) => a & b }],
  ["+", { level: 1, of: (a, b) => a + b }],
  ...["-", "−"].map((sign): [string, Operator] => [sign, { level: 1, of: (a, b) => a - b }]),
  ...["*", "·", "×"].map((sign): [string, Operator] => [sign, { level: 2, of: (a, b) => a * b }]),
  ["/", { level: 2, of: (a, b) => a / b }],
]);

class Parser {
  #next = 0;
  size: 1 | 2 = 1;

  constructor(
    private readonly text: string,
    private readonly tokens: Token[],
  ) {}

  whole(): Node {
    const node = this.operation();
    const rest = this.tokens[this.#next];
    if (rest) throw new FormulaProblem("sign", rest.at, rest.text);
    return node;
  }

  private peek(): string | undefined {
    return this.tokens[this.#next]?.text;
  }

  /** Operands of this level and all that bind stronger, from left to right. */
  private operation(level = 0): Node {
    if (level > 2) return this.unary();
    let left = this.operation(level + 1);
    for (;;) {
      const operator = OPERATORS.get(this.peek() ?? "");
      if (operator?.level !== level) return left;
      this.#next++;
      const a = left;
      const b = this.operation(level + 1);
      left = (d) => operator.of(a(d), b(d));
    }
  }

  private unary(): Node {
    if (this.peek() === "-" || this.peek() === "−") {
      this.#next++;
      const inner = this.unary();
      return (d) => -inner(d);
    }
    return this.atom();
  }

  private atom(): Node {
    const token = this.tokens[this.#next];
    if (!token) throw new FormulaProblem("end", this.text.length, "");
    this.#next++;
    if (token.text === "(") {
      const inner = this.operation();
      const closing = this.tokens[this.#next];
      if (closing?.text !== ")") {
        throw new FormulaProblem("end", closing?.at ?? this.text.length, closing?.text ?? "");
      }
      this.#next++;
      return inner;
    }
    if (/^\d/.test(token.text)) {
      const value = Number(token.text.replace(",", "."));
      return () => value;
    }
    const variable = VARIABLES.get(token.text.toLowerCase());
    if (variable) {
      if (variable.size === 2) this.size = 2;
      return variable.value;
    }
    const kind = /^[a-z_]/i.test(token.text) ? "name" : "sign";
    throw new FormulaProblem(kind, token.at, token.text);
  }
}

/** Compile a formula. Throws `FormulaProblem`. */
export function compile(text: string): Compiled {
  if (!text.trim()) throw new FormulaProblem("empty", 0, "");
  // The parser recurses once for each parenthesis; the limit bounds the depth.
  if (text.length > LONGEST) throw new FormulaProblem("long", LONGEST, "");
  const parser = new Parser(text, tokens(text));
  const node = parser.whole();
  const size = parser.size;
  return {
    size,
    value: (bytes) => {
      if (bytes.length < size) return null;
      const value = node(bytes);
      return Number.isFinite(value) ? value : null;
    },
  };
}
