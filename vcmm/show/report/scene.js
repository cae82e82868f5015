// Draws the scenes of a page with plotly when they are scrolled into view; the poster stands where that cannot be.
(() => {
  const packed = document.getElementById("plotly-gz");
  const gl = document.createElement("canvas").getContext("webgl");
  if (!packed || !gl || !window.DecompressionStream) return;
  let library;
  const load = () => library ??= (async () => {
    const bytes = Uint8Array.from(atob(packed.textContent), c => c.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    const script = document.createElement("script");
    script.textContent = await new Response(stream).text();
    document.head.append(script);
    return window.Plotly;
  })();
  const style = getComputedStyle(document.documentElement);
  const coloured = value => {
    if (typeof value === "string") return value.startsWith("role:") ? style.getPropertyValue("--" + value.slice(5)).trim() : value;
    if (Array.isArray(value)) return value.length && typeof value[0] === "number" && typeof value.at(-1) === "number" ? value : value.map(coloured);
    if (value && typeof value === "object") return Object.fromEntries(Object.entries(value).map(([k, v]) => [k, coloured(v)]));
    return value;
  };
  // Ellipsoids come as one ball, and for each its centre and the root of its covariance, row by row.
  const grown = trace => {
    const {centres, roots} = trace.meta, ball = trace.x.map((x, n) => [x, trace.y[n], trace.z[n]]), many = ball.length;
    const place = a => centres.flatMap((c, e) => ball.map(p => c[a] + roots[e][3 * a] * p[0] + roots[e][3 * a + 1] * p[1] + roots[e][3 * a + 2] * p[2]));
    const faces = own => centres.flatMap((_, e) => own.map(v => v + e * many));
    return {...trace, x: place(0), y: place(1), z: place(2), i: faces(trace.i), j: faces(trace.j), k: faces(trace.k), hovertext: trace.hovertext.flatMap(t => Array(many).fill(t))};
  };
  const ready = given => {
    const figure = coloured(given);
    return {...figure, data: figure.data.map(trace => trace.meta ? grown(trace) : trace)};
  };
  // What has nothing to say must not stand between the pointer and what has: plotly draws it into its picking buffer all the same.
  const silence = live => {
    const scene = live._fullLayout?.scene?._scene, mute = () => {};
    for (const trace of Object.values(scene?.traces ?? {})) if (trace.data?.hoverinfo === "skip") for (const part of Object.values(trace)) if (part?.drawPick) part.drawPick = mute;
    scene?.glplot?.update?.({}); // or the buffer keeps what it has
  };
  window.vcmmScenes = {load, ready, silence, options: {displaylogo: false, responsive: true, modeBarButtonsToRemove: ["tableRotation", "resetCameraLastSave3d"]}};
  const turned = (eye, around, up) => {
    const r = Math.hypot(eye.x, eye.y, eye.z), a = Math.atan2(eye.y, eye.x) + around;
    const e = Math.min(1.55, Math.max(-1.55, Math.asin(eye.z / r) + up));
    return {x: r * Math.cos(e) * Math.cos(a), y: r * Math.cos(e) * Math.sin(a), z: r * Math.sin(e)};
  };
  const STEP = Math.PI / 36, KEYS = {ArrowLeft: [-STEP, 0], ArrowRight: [STEP, 0], ArrowUp: [0, STEP], ArrowDown: [0, -STEP]};
  for (const store of document.querySelectorAll("script[data-scene]")) {
    const figure = store.parentElement, scene = figure.querySelector(".scene"), live = figure.querySelector(".live");
    const given = JSON.parse(store.textContent), camera = structuredClone(given.layout.scene.camera);
    let drawn = false;
    const draw = async () => {
      if (drawn) return;
      drawn = true;
      const plotly = await load(), {data, layout} = ready(given);
      await plotly.newPlot(live, data, layout, vcmmScenes.options);
      silence(live);
      figure.classList.add("drawn");
    };
    const drop = () => {
      if (!drawn || !window.Plotly) return;
      drawn = false;
      window.Plotly.purge(live);
      figure.classList.remove("drawn");
    };
    new IntersectionObserver(([seen]) => seen.isIntersecting ? draw() : drop(), {rootMargin: "300px"}).observe(scene);
    matchMedia("(prefers-color-scheme:dark)").addEventListener("change", () => { if (drawn) { drop(); draw(); } });
    scene.addEventListener("keydown", event => {
      const now = live.layout && live.layout.scene.camera;
      if (!now || !(event.key in KEYS || event.key === "Home")) return;
      event.preventDefault();
      const eye = event.key === "Home" ? camera.eye : turned(now.eye, ...KEYS[event.key]);
      window.Plotly.relayout(live, {"scene.camera": {...camera, eye}});
    });
    const clip = figure.querySelector(".clip");
    clip.hidden = false;
    for (const axis of "xyz") {
      const [low, high] = given.layout.scene[axis + "axis"].range, edge = given.layout.scene.aspectratio[axis], label = document.createElement("label"), slider = document.createElement("input");
      Object.assign(slider, {type: "range", min: 1, max: 100, value: 100, ariaLabel: "clip along " + axis});
      slider.oninput = () => window.Plotly && drawn && window.Plotly.relayout(live, {[`scene.${axis}axis.range`]: [low, low + (high - low) * slider.value / 100], [`scene.aspectratio.${axis}`]: edge * slider.value / 100, "scene.camera": live.layout.scene.camera});
      label.append("clip " + axis.toUpperCase() + " ", slider);
      clip.append(label);
    }
  }
})();
