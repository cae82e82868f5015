// The path of a program on a canvas: by error, feed or tool, rapids dashed, the line under the pointer, a slider along the program;
// beside it the program, each linked to the other, which can be searched. A triad of the axes and a scale of lengths stand in the corner.
(() => {
  const box = document.currentScript.parentElement;
  const all = JSON.parse(box.querySelector("script[type='application/json']").textContent);
  const canvas = box.querySelector("canvas"), slider = box.querySelector("input[type=range]"), told = box.querySelector("output");
  const chosen = (name, other) => box.querySelector(`select[name=${name}]`)?.value ?? other;
  const views = { top: [[1, 0, 0], [0, 1, 0]], front: [[1, 0, 0], [0, 0, 1]], side: [[0, 1, 0], [0, 0, 1]],
    lathe: [[0, 0, 1], [1, 0, 0]], space: [[0.866, 0.5, 0], [-0.25, 0.433, 0.866]] };
  const TOOLS = ["#2a6fdb", "#d9622b", "#2f9e63", "#a63bb5", "#b58a1b", "#1b9aaa", "#c23a57", "#6b7a8f"], NONE = "#98a2ad", MARK = "#e11d48";
  const tools = [...new Set(all.paths.flatMap(p => p.tool))];
  let view = views[all.view], zoom = 1, shift = [0, 0], flat = [], scale = 1, origin = [0, 0], over = -1;
  let d = all.paths[0], n = d.line.length, kind = "tool";
  const band = (scale, v) => { let k = 0; while (k < scale.colours.length - 1 && v >= scale.levels[k + 1]) k++; return scale.colours[k]; };
  const colour = i => {
    if (d.rapid[i]) return NONE;
    if (kind === "tool") return TOOLS[tools.indexOf(d.tool[i]) % TOOLS.length];
    const v = d[kind][i];
    return v === null || v === undefined ? NONE : band(all[kind], v);
  };
  function choose() {
    d = all.paths[Number(chosen("program", 0))]; n = d.line.length;
    kind = chosen("colour", "tool");
    box.querySelectorAll("[data-scale]").forEach(e => { e.hidden = e.dataset.scale !== kind; });
    firsts(); legendOfTools();
    const share = slider.value / slider.max;
    slider.max = n; slider.value = Math.round(share * n); over = -1;
    size();
  }
  function project() {
    flat = new Float64Array(2 * (n + 1));
    const cut = d.rapid.some(r => !r), shown = d.x.map((_, i) => !cut || (i > 0 && !d.rapid[i - 1]) || d.rapid[i] === 0); // fitted to what cuts
    let lo = [Infinity, Infinity], hi = [-Infinity, -Infinity];
    for (let i = 0; i <= n; i++) for (let k = 0; k < 2; k++) {
      const v = view[k], q = v[0] * d.x[i] + v[1] * d.y[i] + v[2] * d.z[i];
      flat[2 * i + k] = q;
      if (shown[i]) { lo[k] = Math.min(lo[k], q); hi[k] = Math.max(hi[k], q); }
    }
    const w = canvas.width, h = canvas.height;
    scale = 0.92 * Math.min(w / (hi[0] - lo[0] || 1), h / (hi[1] - lo[1] || 1));
    origin = [w / 2 - scale * (lo[0] + hi[0]) / 2, h / 2 + scale * (lo[1] + hi[1]) / 2];
  }
  const at = (i) => [(origin[0] + scale * flat[2 * i] - canvas.width / 2) * zoom + canvas.width / 2 + shift[0],
    (origin[1] - scale * flat[2 * i + 1] - canvas.height / 2) * zoom + canvas.height / 2 + shift[1]];
  function draw() {
    const c = canvas.getContext("2d"), last = Number(slider.value);
    c.clearRect(0, 0, canvas.width, canvas.height);
    c.beginPath(); c.setLineDash([]); c.lineWidth = 0.8; c.strokeStyle = "#d3d9e0"; // what is still to come
    for (let i = last; i < n; i++) if (!d.rapid[i]) { c.moveTo(...at(i)); c.lineTo(...at(i + 1)); }
    c.stroke();
    let group = null;
    for (let i = 0; i < last; i++) {
      const key = colour(i) + d.rapid[i];
      if (key !== group) {
        if (group !== null) c.stroke();
        group = key;
        c.beginPath();
        c.setLineDash(d.rapid[i] ? [5, 5] : []);
        c.lineWidth = d.rapid[i] ? 0.8 : kind === "tool" ? 1.4 : 2.6;
        c.strokeStyle = colour(i);
        c.moveTo(...at(i));
      }
      c.lineTo(...at(i + 1));
    }
    if (group !== null) c.stroke();
    c.setLineDash([]);
    const mark = over >= 0 ? over : last - 1;
    if (mark >= 0) {
      c.beginPath(); c.lineWidth = 4; c.strokeStyle = MARK; c.moveTo(...at(mark)); c.lineTo(...at(mark + 1)); c.stroke();
      const p = at(mark + 1); c.beginPath(); c.arc(p[0], p[1], 4, 0, 7); c.fillStyle = MARK; c.fill();
      const feed = d.rapid[mark] ? "rapid" : d.feed[mark] === null ? "feed not known" : d.feed[mark] + " mm/min";
      const error = d.error[mark] === undefined || d.error[mark] === null ? "" : `, off by ${d.error[mark].toFixed(2)} µm`;
      told.textContent = `line ${d.line[mark]}: ${all.text[d.line[mark]] ?? ""}   |  T${d.tool[mark]}, ${feed}${error}, to X ${d.x[mark + 1]} ` +
        `Y ${d.y[mark + 1]} Z ${d.z[mark + 1]} mm   (${mark + 1} of ${n})`;
    }
    corner(c);
    show(mark);
    box.dataset.drawn = `${chosen("program", 0)} ${kind} ${last}`;
  }
  // the program: a click goes to where a line ends, arrow keys to the next line that moves, words are looked for
  const list = box.querySelector(".listing ol"), search = box.querySelector("input[type=search]"), items = new Map();
  let ends = new Map(), marked = null;
  for (const [number, words] of Object.entries(all.text)) {
    const item = document.createElement("li");
    item.value = Number(number); item.textContent = words;
    items.set(Number(number), item); list.append(item);
  }
  function firsts() {
    ends = new Map(d.line.map((line, i) => [line, i + 1]));
    items.forEach((item, line) => item.classList.toggle("moves", ends.has(line)));
  }
  function show(mark) {
    const item = mark >= 0 ? items.get(d.line[mark]) : undefined;
    if (item === marked) return;
    marked?.removeAttribute("aria-current");
    marked = item;
    if (!item) return;
    item.setAttribute("aria-current", "true");
    const top = item.offsetTop - list.offsetTop;
    if (top < list.scrollTop || top + item.offsetHeight > list.scrollTop + list.clientHeight) list.scrollTop = top - list.clientHeight / 2;
  }
  function go(line) {
    if (!ends.has(line)) return;
    slider.value = ends.get(line); over = -1; draw();
  }
  list.addEventListener("click", (e) => { const item = e.target.closest("li"); if (item) go(item.value); });
  list.addEventListener("keydown", (e) => {
    const step = { ArrowDown: 1, ArrowUp: -1 }[e.key];
    if (!step) return;
    e.preventDefault();
    const lines = [...ends.keys()].filter((line) => !items.get(line)?.hidden).sort((a, b) => a - b), now = marked ? marked.value : 0;
    const next = step > 0 ? lines.find((line) => line > now) : lines.findLast((line) => line < now);
    if (next !== undefined) go(next);
  });
  search.addEventListener("input", () => {
    const words = search.value.trim().toUpperCase();
    items.forEach((item) => { item.hidden = words !== "" && !item.textContent.toUpperCase().includes(words); });
  });
  function legendOfTools() {
    const key = box.querySelector("[data-scale=tool]");
    key.replaceChildren(...tools.map((t, k) => {
      const row = document.createElement("div"), dot = document.createElement("i");
      dot.style.background = TOOLS[k % TOOLS.length]; row.append(dot, `T${t}`);
      return row;
    }));
  }
  function corner(c) {
    const wanted = 110 / (scale * zoom), power = 10 ** Math.floor(Math.log10(wanted));
    const length = power * [5, 2, 1].find((m) => m * power <= wanted), wide = length * scale * zoom;
    const y = canvas.height - 16, x = canvas.width - 20 - wide;
    c.lineWidth = 1.5; c.strokeStyle = c.fillStyle = "#3c4753"; c.font = "12px system-ui, sans-serif";
    c.beginPath(); c.moveTo(x, y - 5); c.lineTo(x, y); c.lineTo(x + wide, y); c.lineTo(x + wide, y - 5); c.stroke();
    c.textAlign = "center"; c.fillText(`${length >= 1 ? length : length.toPrecision(1)} mm`, x + wide / 2, y - 8);
    const foot = [46, canvas.height - 46];
    ["X", "Y", "Z"].forEach((name, k) => {
      const to = [30 * view[0][k], -30 * view[1][k]], far = Math.hypot(...to);
      if (far < 1) return; // towards the eye
      c.beginPath(); c.moveTo(...foot); c.lineTo(foot[0] + to[0], foot[1] + to[1]); c.stroke();
      c.fillText(name, foot[0] + to[0] * (1 + 9 / far), foot[1] + to[1] * (1 + 9 / far) + 4);
    });
    box.dataset.scale = length;
  }
  function size() { canvas.width = canvas.clientWidth; canvas.height = canvas.clientHeight; project(); draw(); }
  slider.addEventListener("input", () => { over = -1; draw(); });
  box.querySelectorAll("select").forEach((s) => s.addEventListener("change", choose));
  box.querySelectorAll("button").forEach((b) => b.addEventListener("click", () => {
    view = views[b.value]; zoom = 1; shift = [0, 0]; project(); draw();
  }));
  let held = null;
  canvas.addEventListener("pointerdown", (e) => { held = [e.clientX - shift[0], e.clientY - shift[1]]; });
  window.addEventListener("pointerup", () => { held = null; });
  canvas.addEventListener("pointermove", (e) => {
    if (held) { shift = [e.clientX - held[0], e.clientY - held[1]]; draw(); return; }
    let best = 100; over = -1;
    const last = Number(slider.value);
    for (let i = 0; i < last; i++) {
      const a = at(i), b = at(i + 1), dx = b[0] - a[0], dy = b[1] - a[1], l = dx * dx + dy * dy;
      const t = l ? Math.max(0, Math.min(1, ((e.offsetX - a[0]) * dx + (e.offsetY - a[1]) * dy) / l)) : 0;
      const far = (a[0] + t * dx - e.offsetX) ** 2 + (a[1] + t * dy - e.offsetY) ** 2;
      if (far <= best) { best = far; over = i; }
    }
    draw();
  });
  canvas.addEventListener("wheel", (e) => { e.preventDefault(); zoom *= e.deltaY < 0 ? 1.2 : 1 / 1.2; draw(); });
  window.addEventListener("resize", size);
  choose();
})();
