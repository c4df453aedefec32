// Lines of the map, drawn with no more points than the screen can show.

/** Points in one piece of a line. A piece beyond the view is one straight line. */
const PIECE = 256;
/** Points nearer than this to the one before are left out, pixels. */
const NEAR_PIXELS = 1;

/** A line with the boxes of its pieces. @param {ArrayLike<number>} line x and y in turn */
function pieces(line) {
  const points = Float64Array.from(line);
  const boxes = [];
  for (let first = 0; first < points.length; first += 2 * PIECE) {
    const box = [Infinity, Infinity, -Infinity, -Infinity];
    // The first point of the next piece belongs to this one, too: the line between them is in its box.
    const end = Math.min(first + 2 * PIECE + 2, points.length);
    for (let k = first; k < end; k += 2) {
      box[0] = Math.min(box[0], points[k]);
      box[1] = Math.min(box[1], points[k + 1]);
      box[2] = Math.max(box[2], points[k]);
      box[3] = Math.max(box[3], points[k + 1]);
    }
    boxes.push(box);
  }
  return { points, boxes };
}

/** Closed or open lines that are drawn together. */
export class Shape {
  /** @param {ArrayLike<number>[]} lines @param {boolean} closed */
  constructor(lines, closed) {
    this.lines = lines.map(pieces);
    this.closed = closed;
    this.seen = "";
    this.path = new Path2D();
    /** Number of points of the path. */
    this.drawn = 0;
  }

  /**
   * The path for a view: its box in drawing coordinates, and the size of a pixel, mm. What lies beyond the view is
   * straightened, and points that a pixel cannot tell apart are left out.
   * @param {number[]} box @param {number} pixel
   */
  of(box, pixel) {
    const seen = `${box} ${pixel}`;
    if (seen === this.seen) return this.path;
    this.seen = seen;
    const path = new Path2D();
    let drawn = 0;
    const near = (NEAR_PIXELS * pixel) ** 2;
    for (const { points, boxes } of this.lines) {
      let [x, y] = points;
      path.moveTo(x, y);
      boxes.forEach((own, number) => {
        const first = 2 * PIECE * number;
        const end = Math.min(first + 2 * PIECE, points.length);
        const apart = own[0] > box[2] || own[2] < box[0] || own[1] > box[3] || own[3] < box[1];
        // Of a piece that is apart, the first and the last point: the line between them is in its box.
        for (let k = first; k < end; k = apart && k === first && k < end - 2 ? end - 2 : k + 2) {
          const far = (points[k] - x) ** 2 + (points[k + 1] - y) ** 2 > near;
          if (!apart && !far && k + 2 < end) continue;
          [x, y] = [points[k], points[k + 1]];
          path.lineTo(x, y);
          drawn += 1;
        }
      });
      if (this.closed) path.closePath();
    }
    this.path = path;
    this.drawn = drawn;
    return path;
  }

  /** The distance of a place to the points of the lines, mm. @param {number[]} at */
  distance([x, y]) {
    let least = Infinity;
    for (const { points } of this.lines) {
      for (let k = 0; k + 3 < points.length + (this.closed ? 2 : 0); k += 2) {
        const next = (k + 2) % points.length;
        const [ax, ay, dx, dy] = [points[k], points[k + 1], points[next] - points[k], points[next + 1] - points[k + 1]];
        const share = Math.min(1, Math.max(0, ((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy || 1)));
        least = Math.min(least, Math.hypot(ax + share * dx - x, ay + share * dy - y));
      }
    }
    return least;
  }
}
