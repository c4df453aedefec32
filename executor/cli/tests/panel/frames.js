// Pans and zooms a map of 100,000 edges, and measures the page's own work and the frames, ms.
(async () => {
  const line = (radius) => {
    const points = [];
    for (let k = 0; k < 25000; k += 1) {
      const phi = (2 * Math.PI * k) / 25000;
      const r = radius + 2 * Math.sin(9 * phi) + 0.1 * Math.sin(997 * phi);
      points.push(40 + r * Math.cos(phi), 25 + r * Math.sin(phi));
    }
    return points;
  };
  const { map } = panel;
  map.take({
    bounds: [-60, -75, 140, 125], faces: [[0, [line(90), line(70)]]], zones: [], rest: [], left_out: [],
    contours: [[1, -1, line(93)], [2, -1, line(67)]], tool_radius_mm: 3,
  });
  const frame = () => new Promise((done) => requestAnimationFrame(done));
  const rank = (all, share) => [...all].sort((a, b) => a - b)[Math.floor(share * (all.length - 1))];
  const both = (all) => [rank(all, 0.5), rank(all, 0.95)];
  const [work, gaps] = [[], []];
  let last = performance.now();
  for (let k = 0; k < 240; k += 1) {
    if (k % 120 < 60) map.view.x += 0.3; else map.zoomBy(k % 120 < 90 ? 1.05 : 1 / 1.05);
    const begun = performance.now();
    map.draw();
    work.push(performance.now() - begun);
    await frame();
    const now = performance.now();
    gaps.push(now - last);
    last = now;
  }
  map.fit();
  const face = map.shapes.faces[0][1];
  const { drawn } = face;
  map.zoomBy(60, [map.canvas.width * 0.93, map.canvas.height / 2]);
  map.draw();
  return { drawn, near: face.drawn, work: both(work), gaps: both(gaps), points: face.lines[0].points.length / 2 };
})();
