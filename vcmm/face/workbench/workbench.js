// The page asks one question at a time: a preview while a knob moves, the whole evaluation once it rests.
(() => {
  const {token} = JSON.parse(document.getElementById("given").textContent);
  const status = document.getElementById("status"), rows = document.getElementById("rows"), form = document.querySelector(".knobs");
  const scenes = [...document.querySelectorAll(".live-scene .live")], REST = 500;
  const knobs = {}, page = Math.random().toString(36).slice(2);
  let busy = false, waiting = false, rest;
  const ask = async (path, body) => {
    const question = {method: "POST", headers: {"Content-Type": "application/json", "X-Token": token}, body: JSON.stringify({...body, page})};
    const answer = await fetch(path, question).catch(() => { throw new Error("the workbench does not answer; start vcmm serve again and open the address that it prints"); });
    const found = await answer.json();
    if (!answer.ok || found.given_up) throw Object.assign(new Error(found.error), {newer: found.given_up});
    return found;
  };
  const cell = (row, text, extra) => { const td = document.createElement("td"); if (extra) td.append(extra); td.append(text); row.append(td); };
  const small = (c, key) => c[key + "_mm"] != null ? (1e3 * c[key + "_mm"]).toPrecision(3) + " µm" : c[key + "_rad"] != null ? (1e6 * c[key + "_rad"]).toPrecision(3) + " µrad" : "–";
  const large = c => c.value_mm != null ? c.value_mm.toFixed(5) + " mm" : (180 / Math.PI * c.value_rad).toFixed(5) + "°";
  const show = found => {
    rows.className = found.preview ? "preview" : "";
    rows.replaceChildren(...found.characteristics.map(c => {
      const row = document.createElement("tr"), bar = document.createElement("span");
      cell(row, c.name);
      cell(row, found.preview ? (c.unit === "um" ? c.value.toFixed(5) + " mm" : (180 / Math.PI * c.value).toFixed(5) + "°") : large(c));
      cell(row, found.preview ? "≈ " + c.U.toPrecision(3) + (c.unit === "um" ? " µm" : " µrad") : small(c, "U"));
      cell(row, found.preview ? "" : c.decision ?? "–");
      const owner = c.budget[0];
      bar.className = "share";
      bar.style.width = owner ? 5 * owner.share + "rem" : 0;
      cell(row, owner ? `${Math.round(100 * owner.share)} % ${owner.what ?? owner.input}` : "", bar);
      return row;
    }));
  };
  const failed = error => {
    if (error.newer) return;
    rows.replaceChildren();  // no figures of other knobs
    delete document.body.dataset.settled;
    status.textContent = error.message;
  };
  const settle = async () => {
    status.textContent = "computing";
    let found;
    try { found = await ask("/settled", {knobs}); } catch (error) { failed(error); return; }
    try {
      show(found);
      status.textContent = "evaluated" + (found.warnings.length ? `; ${found.warnings.length} notes: ${found.warnings[0]}` : "");
      document.body.dataset.settled = JSON.stringify(knobs);
      if (window.vcmmScenes) {
        const plotly = await vcmmScenes.load();
        found.figures.forEach(async (figure, i) => {
          const {data, layout} = vcmmScenes.ready(figure), now = scenes[i].layout;
          if (now) layout.scene.camera = now.scene.camera;
          await plotly.react(scenes[i], data, layout, vcmmScenes.options);
          vcmmScenes.silence(scenes[i]);
        });
      }
    } catch (error) { status.textContent = `evaluated; the scenes cannot be drawn: ${error.message}`; }
  };
  const preview = async () => {
    if (busy) { waiting = true; return; }
    busy = true;
    try { show(await ask("/preview", {knobs})); status.textContent = "preview"; } catch (error) { failed(error); }
    busy = false;
    if (waiting) { waiting = false; preview(); }
  };
  const moved = () => { clearTimeout(rest); rest = setTimeout(settle, REST); preview(); };
  const knob = k => {
    const label = document.createElement("label"), slider = document.createElement("input"), value = document.createElement("output");
    Object.assign(slider, {type: "range", min: k.low, max: k.high, step: k.step === 1 && k.low % 1 ? "any" : k.step, name: k.name});
    slider.value = k.start;
    const tell = () => value.textContent = `${(+slider.value).toFixed(k.step < 1 ? 2 : 0)} ${k.unit}`;
    slider.oninput = () => { knobs[k.name] = +slider.value; tell(); moved(); };
    tell();
    label.append(k.words, value, slider);
    return label;
  };
  const drop = document.getElementById("drop"), found = document.getElementById("found");
  for (const kind of ["dragover", "drop"]) drop.addEventListener(kind, event => event.preventDefault());
  drop.addEventListener("drop", async event => {
    drop.textContent = "diagnosing";
    try {
      const files = Object.fromEntries(await Promise.all([...event.dataTransfer.files].map(async f => [f.name, await f.text()])));
      const told = await ask("/diagnose", {files});
      found.replaceChildren(...told.sentences.map(s => Object.assign(document.createElement("p"), {textContent: s})));
      drop.textContent = told.verdict;
    } catch (error) { drop.textContent = error.message; }
  });
  ask("/state", {}).then(state => { form.replaceChildren(...state.knobs.map(knob)); preview().then(settle); }, failed);
})();
