// The page asks one question at a time: a preview while a knob moves, the whole evaluation once it rests.
(() => {
  const {token} = JSON.parse(document.getElementById("given").textContent), by = id => document.getElementById(id);
  const status = by("status"), rows = by("rows"), form = document.querySelector(".knobs");
  const scenes = [...document.querySelectorAll(".live-scene .live")], REST = 500, POLL = 400;
  const PILLS = {"conforms": "good", "undecided": "warning", "does not conform": "bad"};
  const page = Math.random().toString(36).slice(2), handles = {};
  let knobs = {}, starts = {}, past = [], place = -1;  // past: states of the knobs, oldest first; place: the present one
  let busy = false, waiting = false, rest, settledNow = null, pinned = null, cancelled = false;

  const ask = async (path, body) => {
    const question = {method: "POST", headers: {"Content-Type": "application/json", "X-Token": token}, body: JSON.stringify({...body, page})};
    const answer = await fetch(path, question).catch(() => { throw new Error("the workbench does not answer; start vcmm serve again and open the address that it prints"); });
    const found = await answer.json();
    if (!answer.ok || found.given_up) throw Object.assign(new Error(found.error), {newer: found.given_up});
    return found;
  };
  const long = async (path, body) => {  // with progress, and a button that ends it
    const bar = by("progress"), poll = setInterval(async () => {
      const at = await ask("/progress", {}).catch(() => ({}));
      if (at.share == null) bar.removeAttribute("value"); else bar.value = at.share;
      if (at.text) bar.title = at.text;
    }, POLL);
    bar.removeAttribute("value");
    bar.hidden = by("cancel").hidden = false;
    cancelled = false;
    try { return await ask(path, body); } finally { clearInterval(poll); bar.hidden = by("cancel").hidden = true; }
  };
  const make = (kind, properties, ...inside) => { const made = Object.assign(document.createElement(kind), properties); made.append(...inside); return made; };

  // ---- the answer
  const small = (c, key) => c[key + "_mm"] != null ? (1e3 * c[key + "_mm"]).toPrecision(3) + " µm" : c[key + "_rad"] != null ? (1e6 * c[key + "_rad"]).toPrecision(3) + " µrad" : "–";
  const large = c => c.value_mm != null ? c.value_mm.toFixed(5) + " mm" : (180 / Math.PI * c.value_rad).toFixed(5) + "°";
  const pill = text => text ? make("span", {className: `badge ${PILLS[text] ?? "muted"}`}, text) : "–";
  const show = found => {
    rows.className = found.preview ? "preview" : "";
    rows.replaceChildren(...found.characteristics.map((c, i) => {
      const owner = c.budget[0], bar = make("span", {className: "share"}), was = pinned?.characteristics[i];
      bar.style.width = owner ? 5 * owner.share + "rem" : 0;
      const value = found.preview ? (c.unit === "um" ? c.value.toFixed(5) + " mm" : (180 / Math.PI * c.value).toFixed(5) + "°") : large(c);
      const U = found.preview ? "≈ " + c.U.toPrecision(3) + (c.unit === "um" ? " µm" : " µrad") : small(c, "U");
      const likely = !found.preview && c.p_conform != null ? ` ${(100 * c.p_conform).toFixed(1)} %` : "";
      const row = make("tr", {}, make("td", {}, c.name), make("td", {}, value), make("td", {}, U),
        make("td", {}, found.preview ? "" : pill(c.decision), likely),
        make("td", {}, bar, owner ? `${Math.round(100 * owner.share)} % ${owner.what ?? owner.input}` : ""));
      const beside = make("td", {className: "pinned"});
      if (was) beside.append(`U ${small(was, "U")} `, pill(was.decision));
      row.append(beside);
      return row;
    }));
    document.body.toggleAttribute("data-pinned", !!pinned);
  };
  const failed = error => {
    if (error.newer) { if (cancelled) status.textContent = "cancelled; the figures are a preview"; return; }
    rows.replaceChildren();  // no figures of other knobs
    by("pictures").replaceChildren();
    delete document.body.dataset.settled;
    settledNow = null;
    by("pin").disabled = true;
    status.textContent = error.message;
  };
  const draw = async figures => {  // the scenes, as far as they are there: a preview has the first
    if (!window.vcmmScenes) return;
    const plotly = await vcmmScenes.load();
    await Promise.all(figures.map(async (figure, i) => {
      const {data, layout} = vcmmScenes.ready(figure), now = scenes[i].layout;
      if (now) layout.scene.camera = now.scene.camera;
      await plotly.react(scenes[i], data, layout, vcmmScenes.options);
      vcmmScenes.silence(scenes[i]);
    }));
  };
  const settle = async () => {
    status.textContent = "computing";
    const at = {...knobs};
    let found;
    try { found = await long("/settled", {knobs: at}); } catch (error) { failed(error); return; }
    try {
      settledNow = {knobs: at, characteristics: found.characteristics};
      by("pin").disabled = false;
      show(found);
      status.textContent = "evaluated" + (found.warnings.length ? `; ${found.warnings.length} notes: ${found.warnings[0]}` : "");
      by("pictures").replaceChildren(...found.pictures.map((picture, i) => {  // made and escaped by the server
        const box = make("div");
        box.innerHTML = picture;
        if (picture) box.prepend(make("p", {className: "about"}, found.characteristics[i].name));
        return box;
      }).filter(box => box.children.length));
      document.body.dataset.settled = JSON.stringify(at);
      await draw(found.figures);
    } catch (error) { status.textContent = `evaluated; the scenes cannot be drawn: ${error.message}`; }
  };
  const preview = async () => {
    if (busy) { waiting = true; return; }
    busy = true;
    try {
      const found = await ask("/preview", {knobs});
      show(found);
      status.textContent = "preview";
      await draw(found.figures).catch(() => {});  // of which the settled one tells
    } catch (error) { failed(error); }
    busy = false;
    if (waiting) { waiting = false; preview(); }
  };

  // ---- knobs, their past, and the address
  const same = (a, b) => Object.keys(starts).every(name => (a[name] ?? starts[name]) === (b[name] ?? starts[name]));
  const buttons = () => { by("undo").disabled = place < 1; by("redo").disabled = place >= past.length - 1; };
  const remember = () => {
    if (place >= 0 && same(past[place], knobs)) return;
    past = [...past.slice(0, place + 1), {...knobs}];
    place = past.length - 1;
    buttons();
  };
  const toAddress = () => {
    const moved = Object.entries(knobs).filter(([name, value]) => value !== starts[name]);
    history.replaceState(null, "", location.pathname + location.search + (moved.length ? "#" + new URLSearchParams(moved) : ""));
  };
  const fromAddress = () => Object.fromEntries([...new URLSearchParams(location.hash.slice(1))]
    .filter(([name, value]) => name in starts && value !== "" && Number.isFinite(+value)).map(([name, value]) => [name, +value]));
  const moved = () => {
    clearTimeout(rest);
    rest = setTimeout(() => { remember(); toAddress(); settle(); }, REST);
    preview();
  };
  const turn = state => {  // all knobs at once: undo, redo, reset, A, the address
    knobs = {...starts, ...state};
    for (const [name, handle] of Object.entries(handles)) handle(knobs[name]);
  };
  const turned = state => { turn(state); toAddress(); buttons(); clearTimeout(rest); preview().then(settle); };
  const step = way => { const to = place + way; if (to < 0 || to >= past.length) return; place = to; turned(past[place]); };
  const knob = k => {
    const slider = make("input", {type: "range", min: k.low, max: k.high, step: "any", name: k.name});
    const figure = make("input", {type: "number", min: k.low, max: k.high, step: k.step});
    figure.setAttribute("aria-label", `${k.words}, as a number`);
    figure.dataset.knob = k.name;
    if (k.step === 1 && k.low % 1 === 0) slider.step = 1; else figure.step = "any";
    const text = value => String(+value.toFixed(k.step < 1 ? 4 : 3));
    handles[k.name] = value => { slider.value = value; figure.value = text(value); };
    handles[k.name](k.start);
    slider.oninput = () => { knobs[k.name] = +slider.value; figure.value = text(+slider.value); moved(); };
    figure.onchange = () => {
      if (!figure.checkValidity() || figure.value === "") { status.textContent = `${k.words}: ${k.low} to ${k.high} ${k.unit}`; figure.value = text(knobs[k.name] ?? k.start); return; }
      slider.value = knobs[k.name] = +figure.value;
      moved();
    };
    return make("div", {className: "knob"}, make("label", {}, make("span", {}, k.words), slider), figure, make("span", {className: "unit"}, k.unit));
  };
  by("undo").onclick = () => step(-1);
  by("redo").onclick = () => step(1);
  by("reset").onclick = () => { turn({}); remember(); turned({}); };
  by("cancel").onclick = () => { cancelled = true; ask("/cancel", {}).catch(() => {}); };
  by("pin").onclick = () => { pinned = settledNow; by("swap").hidden = false; show({...settledNow, preview: false}); };
  by("swap").onclick = () => { const to = pinned.knobs; if (settledNow) pinned = settledNow; turn(to); remember(); turned(to); };
  form.addEventListener("submit", event => event.preventDefault());
  document.addEventListener("keydown", event => {
    if (!(event.ctrlKey || event.metaKey) || event.target.type === "number") return;
    const key = event.key.toLowerCase();
    if (key === "z" || key === "y") { event.preventDefault(); step(key === "y" || event.shiftKey ? 1 : -1); }
  });
  window.addEventListener("hashchange", () => { const state = fromAddress(); if (!same(state, knobs)) { turn(state); remember(); turned(state); } });

  // ---- save, sweep
  const keep = (name, text, type) => {
    const link = make("a", {href: URL.createObjectURL(new Blob([text], {type})), download: name});
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  };
  by("save").onclick = async () => {
    try {
      const {name, toml} = await ask("/save", {knobs});
      keep(name, toml, "application/toml");
      status.textContent = `saved as ${name}; keep it in the folder of the scenario that is open, whose files it names`;
    } catch (error) { status.textContent = error.message; }
  };
  by("sweep").onclick = async () => {
    const swept = by("swept");
    status.textContent = "sweep";
    try {
      const found = await long("/sweep", {knobs, knob: by("along").value});
      swept.innerHTML = found.pictures.join("");  // made and escaped by the server
      swept.append(...found.reasons.slice(0, 1).map(text => make("p", {className: "note"}, `${found.reasons.length} of ${found.at.length} places without an answer: ${text}`)));
      status.textContent = "sweep: previews, all other knobs as they stand";
      if (rows.className === "preview") await settle();  // which the sweep has ended
    } catch (error) { status.textContent = error.newer ? "the sweep was ended" : error.message; }
  };

  // ---- files: dropped, chosen, or a whole folder
  const drop = by("drop"), found = by("found"), said = by("said");
  const inside = async (entry, before = "") => {
    if (entry.isFile) return [[before + entry.name, await new Promise((ready, not) => entry.file(ready, not))]];
    const reader = entry.createReader(), out = [];
    for (let part; (part = await new Promise((ready, not) => reader.readEntries(ready, not))).length;) {
      for (const one of part) out.push(...await inside(one, `${before}${entry.name}/`));
    }
    return out;
  };
  const job = async (name, files, telling) => {
    telling.textContent = name ? `${name}: under way` : "under way";
    try {
      const told = await long("/job", {job: name, files, knobs});
      found.replaceChildren(...told.said.map(s => make("p", {textContent: s})));
      by("report").hidden = by("keep").hidden = !told.report;
      by("report").srcdoc = told.report;
      by("keep").onclick = () => keep(`${told.job}.html`, told.report, "text/html");
      telling.textContent = told.verdict ?? `${told.job}: done, below`;
      if (rows.className === "preview") await settle();  // which the job has ended
    } catch (error) { telling.textContent = error.newer ? "ended" : error.message; }
  };
  for (const name of ["measure", "place"]) by(name).onclick = () => job(name, null, status);
  const take = async pairs => {
    const files = Object.fromEntries(await Promise.all((await pairs).map(async ([name, file]) => [name, await file.text()])));
    await job(by("what").value, files, said);
  };
  for (const kind of ["dragover", "drop"]) drop.addEventListener(kind, event => event.preventDefault());
  drop.addEventListener("drop", event => {
    const entries = [...event.dataTransfer.items].map(item => item.webkitGetAsEntry?.()).filter(Boolean);
    const whole = entries.length ? Promise.all(entries.map(entry => inside(entry))).then(lists => lists.flat()) : [...event.dataTransfer.files].map(f => [f.name, f]);
    take(whole);
  });
  for (const [button, input] of [["files", "chosen"], ["folder", "whole"]]) {
    by(button).onclick = () => by(input).click();
    by(input).onchange = () => { take([...by(input).files].map(f => [f.webkitRelativePath || f.name, f])); by(input).value = ""; };
  }

  ask("/state", {}).then(state => {
    form.replaceChildren(...state.knobs.map(knob));
    starts = Object.fromEntries(state.knobs.map(k => [k.name, k.start]));
    by("along").append(...state.knobs.map(k => make("option", {value: k.name, textContent: k.words})));
    turn({...state.turned, ...fromAddress()});
    remember();
    preview().then(settle);
  }, failed);
})();
