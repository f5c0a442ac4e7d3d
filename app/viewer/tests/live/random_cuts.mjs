// Cuts at random, the same every time, for tests and trials of the live page.

/** Numbers in [0, 1) (mulberry32). */
export function randomNumbers(seed) {
  return () => {
    seed = (seed + 0x6d2b79f5) | 0;
    let t = Math.imul(seed ^ (seed >>> 15), 1 | seed);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 2 ** 32;
  };
}

/** What the page may ask for: regions with a margin, half-spaces and blades anywhere, of which half part. */
export function randomCuts(body, count, random) {
  const within = (low, high) => low + (high - low) * random();
  const axis = (i) => body.points.filter((_, j) => j % 3 === i);
  const box = [0, 1, 2].map((i) => [Math.min(...axis(i)), Math.max(...axis(i))]);
  const place = () => box.map(([low, high]) => within(low, high));
  const way = () => [0, 1, 2].map(() => within(-1, 1));
  const blade = () => {
    const [at, along, across] = [place(), way().map((x) => 0.05 * x), way().map((x) => 0.05 * x)];
    const corner = (a, b) => at.map((x, i) => x + a * along[i] + b * across[i]);
    return { kind: 'blade', corners: [corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)], thickness: random() < 0.5 ? 0 : 0.001 };
  };
  const tools = [
    blade,
    () => ({ kind: 'half-space', point: place(), normal: way() }),
    () => ({ kind: 'region', region: 1 + Math.floor(random() * (body.density.length - 1)), margin: within(0, 0.01), keepsMargin: random() < 0.5, opens: random() < 0.5 }),
  ];
  const numKinds = body.density.length > 1 ? 3 : 2;
  return Array.from({ length: count }, () => ({ tool: tools[Math.floor(random() * numKinds)](), takesLoose: random() < 0.7 }));
}

/** Whether each edge of some triangles is there from both sides. @param triangles  node numbers */
export function isClosed(triangles) {
  const balance = new Map();
  for (let k = 0; k < triangles.length; k += 3)
    for (const [a, b] of [[0, 1], [1, 2], [2, 0]].map((side) => side.map((c) => triangles[k + c]))) {
      const edge = Math.min(a, b) * 1e6 + Math.max(a, b);
      balance.set(edge, (balance.get(edge) ?? 0) + Math.sign(b - a));
    }
  return [...balance.values()].every((sum) => sum === 0);
}
