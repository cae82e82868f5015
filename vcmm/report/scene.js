// Turns the scenes of a page by drag or arrow keys. Twin of scene_paint.py: change both.
for (const data of document.querySelectorAll('script[data-scene]')) {
  const D = JSON.parse(data.textContent), box = data.closest('figure').querySelector('svg'), part = c => box.querySelector(c);
  const n = v => v.toFixed(1), dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const join = rows => rows.sort((a, b) => a[0] - b[0]).map(r => r[1]).join('');
  let [az, el] = D.view, wait = 0;
  function draw() {
    wait = 0;
    const [ca, sa, ce, se] = [az, el].flatMap(v => [Math.cos(v * Math.PI / 180), Math.sin(v * Math.PI / 180)]);
    const F = [[-sa, ca, 0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]], seen = v => F.map(r => dot(r, v)), C = D.v.map(seen);
    const fit = j => D.fit[j + 2] / C.reduce((m, c) => Math.max(m, Math.abs(c[j])), 1), k = Math.min(fit(0), fit(1));
    const P = C.map(c => [D.fit[0] + k * c[0], D.fit[1] - k * c[1]]), at = i => n(P[i][0]) + ' ' + n(P[i][1]);
    const faces = D.f.map(([s, g, m, ...q]) => {
      const N = seen(D.n[m]), [r, v, b, alpha, cull, shade] = D.s[s];
      if (cull && N[2] <= 0) return;
      const tone = 1 - shade + shade * Math.max(0, dot(N, D.light) * Math.sign(N[2]));
      const rgb = `rgb(${[r, v, b].map(c => Math.round(c * tone))})`;
      return [q.reduce((z, i) => z + C[i][2], 0) / q.length, `<path d="M${q.map(at).join('L')}Z" fill="${rgb}" ` +
        (alpha < 1 ? `fill-opacity="${alpha}" shape-rendering="crispEdges"/>` : `stroke="${rgb}" stroke-width=".9"/>`), g];
    });
    const leaf = t => {
      const near = {}, rows = t.i.map(i => faces[i]).filter(f => f);
      for (const f of rows) near[f[2]] = f[0];
      for (const [s, p, q, ...g] of t.i.filter(i => i < 0).map(i => D.e[-1 - i])) {
        const b = g.filter(x => x in near).map(x => near[x]);
        if (b.length || !g.length) rows.push([60 + (t.m || !g.length ? (C[p][2] + C[q][2]) / 2 : Math.max(...b)), `<path d="M${at(p)}L${at(q)}" ${D.s[s]}/>`]);
      }
      return join(rows);
    };
    const walk = t => t.i ? leaf(t) : F[2][t[0]] > 0 ? walk(t[1]) + walk(t[2]) : walk(t[2]) + walk(t[1]);
    const over = D.q.map(([s, c, ...q]) => {
      const m = (i, j) => dot(F[i], q.map(r => dot(r, F[j]))), a = Math.sqrt(m(0, 0)) || 1e-9, h = m(0, 1) / a;
      const M = [a * k, -h * k, 0, k * Math.sqrt(Math.max(m(1, 1) - h * h, 0)), ...P[c]];
      return [C[c][2], `<circle r="1" vector-effect="non-scaling-stroke" transform="matrix(${M})" ${D.s[s]}/>`];
    });
    for (const [s, i, j] of D.a) {
      const dx = P[j][0] - P[i][0], dy = P[j][1] - P[i][1], f = Math.min(1, Math.hypot(dx, dy) / 14);
      over.push([C[j][2], `<path d="M${at(i)}L${at(j)}" ${D.s[s]}/><path d="M0 0L-7 2.6V-2.6Z" transform="translate(${at(j)}) rotate(${n(Math.atan2(dy, dx) * 180 / Math.PI)}) scale(${f})" ${D.s[s]}/>`]);
    }
    for (const [s, i, r] of D.p) over.push([C[i][2], `<circle transform="translate(${at(i)})" r="${r}" ${D.s[s]}/>`]);
    for (const [i, dx, dy, t] of D.l) over.push([1e9, `<text x="${n(P[i][0] + dx)}" y="${n(P[i][1] + dy)}" ${D.label}>${t}</text>`]);
    part('.stage').innerHTML = walk(D.t) + join(over);
    if (!D.bar) return;
    const most = D.bar * D.grain / k, p = 10 ** Math.floor(Math.log10(most)), len = [5, 2, 1].find(f => f * p <= most * 1.000001) * p;
    part('.bar path').setAttribute('d', `M0 -4v8m0 -4H${n(-len * k / D.grain)}m0 -4v8`);
    part('.bar text').textContent = +len.toPrecision(3) + ' mm';
    [...part('.triad').children].map((e, i) => {
      const x = 24 * F[0][i], y = -24 * F[1][i];
      e.children[0].setAttribute('d', `M0 0L${n(x)} ${n(y)}`);
      e.children[1].setAttribute('transform', `translate(${n(1.4 * x)} ${n(1.4 * y + 4)})`);
    });
  }
  const turn = (x, y) => { az -= x; el = Math.min(90, Math.max(-90, el + y)); wait = wait || requestAnimationFrame(draw); };
  box.tabIndex = 0;
  box.closest('figure').classList.add('turns');
  box.onpointerdown = e => box.setPointerCapture(e.pointerId);
  box.onpointermove = e => e.buttons && turn(e.movementX / 2, e.movementY / 2);
  box.ondblclick = () => { [az, el] = D.view; turn(0, 0); };
  box.onkeydown = e => { const s = { ArrowLeft: [-5, 0], ArrowRight: [5, 0], ArrowUp: [0, -5], ArrowDown: [0, 5] }[e.key]; if (s) { turn(...s); e.preventDefault(); } };
}
