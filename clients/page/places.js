// Where in a JSON text the value of a JSON Pointer stands, and where in it a column of an expression is.

const escape = key => key.replaceAll("~", "~0").replaceAll("/", "~1");

// Pointer -> [start, end). Reads as far as the text is JSON.
export function places(text) {
  const out = new Map();
  let at = 0;
  const blank = () => { while (at < text.length && " \t\r\n".includes(text[at])) at++; };
  const string = () => {
    const start = at++;
    while (at < text.length && text[at] !== '"') at += text[at] === "\\" ? 2 : 1;
    at++;
    return start;
  };
  const value = (pointer, depth) => {
    blank();
    const start = at, open = text[at];
    if (depth > 70 || at >= text.length) throw new SyntaxError();
    if (open === '"') string();
    else if (open === "{" || open === "[") {
      const close = open === "{" ? "}" : "]";
      at++;
      for (let i = 0; blank(), text[at] !== close; i++) {
        let key = String(i);
        if (open === "{") {
          const from = string();
          key = JSON.parse(text.slice(from, at));
          blank();
          if (text[at++] !== ":") throw new SyntaxError();
        }
        value(`${pointer}/${escape(key)}`, depth + 1);
        blank();
        if (text[at] === ",") at++;
        else if (text[at] !== close) throw new SyntaxError();
      }
      at++;
    } else {
      while (at < text.length && !" \t\r\n,]}".includes(text[at])) at++;
      if (at === start) throw new SyntaxError();
    }
    out.set(pointer, [start, at]);
  };
  try { value("", 0); } catch { /* what stands before the fault is known */ }
  return out;
}

// The offset of a line and column (from 1, in characters) of the text from `start` on; inside a JSON string an escape is one character.
export function offset(text, start, line, column) {
  const quoted = text[start] === '"';
  let at = start + (quoted ? 1 : 0);
  while (at < text.length && (line > 1 || column > 1)) {
    const escaped = quoted && text[at] === "\\", broken = escaped ? text[at + 1] === "n" : text[at] === "\n";
    if (quoted && text[at] === '"') break;
    at += escaped ? (text[at + 1] === "u" ? 6 : 2) : text.codePointAt(at) > 0xffff ? 2 : 1;
    if (line > 1) line -= broken ? 1 : 0;
    else column--;
  }
  return at;
}

// The part of the text that a problem is about: [start, end). `at` maps pointers to parts.
export function range(text, at, problem) {
  if (!problem.pointer && problem.line) {               // the body itself is no JSON
    const from = offset(text, 0, problem.line, problem.column || 1);
    return [Math.min(from, Math.max(0, text.length - 1)), Math.min(from + 1, text.length)];
  }
  let pointer = problem.pointer || "", exact = true;
  while (!at.has(pointer) && pointer) {
    pointer = pointer.slice(0, pointer.lastIndexOf("/"));
    exact = false;
  }
  const place = at.get(pointer);
  if (!place) return [0, 0];
  let [start, end] = place;
  if (exact && problem.line) {
    start = Math.min(offset(text, start, problem.line, problem.column || 1), Math.max(start, end - (text[start] === '"' ? 2 : 1)));
    const word = /^([A-Za-z_]\w*(?:\[[^\][]*\])?'*|[\d.]+|.)/u.exec(text.slice(start, end));
    return [start, Math.max(start + 1, start + (word ? word[0].length : 1))];
  }
  if (!pointer) return [0, 0];
  return [start, /^[{[]/.test(text.slice(start)) ? start + 1 : end];
}
