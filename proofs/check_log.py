#!/usr/bin/env python3
"""Checks logs of sessions against their plan: a second implementation, for assessors.

    python3 proofs/check_log.py [--band N] PLAN LOG [LOG ...]

It shares no code with Keepout, needs only Python 3.9, and decides in integers and fractions. The unit is 10 nm.
docs/integrator/formats.md describes the files. Exit code 0: every rule holds. 5: a rule does not hold; the output names
file, line, rule and reason. 2: bad arguments, or a file that cannot be read.
A tool whose tip is at height z must not enter K(z): all of the part and the keep-out zones whose top is above z, and
everything if z is below the table. A plan for two axes has one K for all heights.
R1  The plan file is intact: mark, version, SHA-256 of its content. The log names the SHA-256 of this plan file, and
    a third axis if the plan has heights.
R2  The log is intact: each line begins with the CRC-32 of the checksum before it and of the rest of the line. Each
    line has its form, and no time is earlier than the one before. An incomplete last line is left out.
R3  A jog's in-flight set holds the target, and its lowest height is not above the target. The convex hull of the set
    (the box around it, if the axes are not interpolated) is outside K(lowest height - height margin), and farther
    from it than the jogging clearance. Exception: a retract move, from one place (two, if a rise follows). The way from
    there straight to the target comes nearer to no edge within the jogging clearance, and is not lower than before.
R4  A motion of a contour is outside K(lower end - height margin), and farther from it than the finishing clearance
    and 10 units (0.1 um). Without interpolation, so is the box around it, but for the 10 units.
R5  GRBL and grblHAL: each certificate is followed at once by its text, with its target, feed, radius and direction.
    Nothing else is sent that moves the machine, but $H (homing), and no feed hold and no jog cancel. The texts of other
    languages are not compared.
Arcs count as chords that leave them by at most 8 units; 8 units are added to the clearance from an arc of the part.
Keepout takes other chords. So the two may differ about a motion that is within 40 units (0.4 um) of the limit at an
arc. Planned motions keep a greater distance from the limit. `--band N` adds N units to each clearance at an arc.
Not checked: that the plan fits its drawing and machine (`keepout verify`); that the machine stood where it was
reported; that the set holds every place where the tool can be (`keepout replay` runs the guard again: the reports
between two certificates move the confirmed place, and only the guard can follow that); the height at which the first
motion after a start began; the travel; the outcome; homing; of events that no rule reads, all but the name.
"""
import hashlib, json, re, struct, sys, zlib
from fractions import Fraction
from functools import lru_cache
from math import isqrt

LATTICE, CHORD = 1 << 29, 8  # the largest coordinate; the most that a chord leaves its arc
LINE_MAX, PLAN_MAX, KEPT_MAX = 1 << 26, 1 << 30, 100_000  # bytes of a line and of a plan; decisions that are kept

class Fault(Exception): """A rule that does not hold, and the reason."""
def need(holds, reason):
    if not holds:
        raise Fault(reason)

# --- Geometry. A point is a pair of integers. An edge is (a, b, bound, is_arc): a line, at most bound from its curve.
def cross(o, a, b):
    """Positive if b lies to the left of the line from o to a."""
    return (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])
def dot(o, a, b): return (a[0] - o[0]) * (b[0] - o[0]) + (a[1] - o[1]) * (b[1] - o[1])
def nearest_end(p, a, b):
    """The end of the segment a b that is nearest to p, or None if a point between the ends is nearer."""
    along = dot(a, p, b)
    return a if along <= 0 else b if along >= dot(a, b, b) else None
def point_near(p, a, b, reach):
    """Whether the point p is within reach of the segment a b."""
    end = nearest_end(p, a, b)
    return dot(end, p, p) <= reach * reach if end else cross(a, b, p) ** 2 <= reach * reach * dot(a, b, b)
def segments_near(a, b, p, q, reach):
    """Whether two segments are within reach of each other. If they do not cross, they are nearest at an end."""
    crossed = cross(a, b, p) * cross(a, b, q) < 0 and cross(p, q, a) * cross(p, q, b) < 0
    return crossed or any(point_near(*end, reach) for end in ((a, p, q), (b, p, q), (p, a, b), (q, a, b)))
def approaches(p, q, a, b):
    """Whether the way from p to q leads nearer to the segment a b. The distance is convex along the way, so it falls
    at the start or never."""
    end = nearest_end(p, a, b)
    return dot(p, end, q) > 0 if end else cross(a, b, p) * (cross(a, b, q) - cross(a, b, p)) < 0
def hull(points):
    """The corners of the convex hull, counter-clockwise (Andrew's monotone chain)."""
    points, corners = sorted(set(points)), []
    for run in (points, points[::-1]) if len(points) > 2 else ():
        chain = []
        for p in run:
            while len(chain) > 1 and cross(chain[-2], chain[-1], p) <= 0:
                chain.pop()
            chain.append(p)
        corners += chain[:-1]
    return corners or points
def box(points, reach=0):
    xs, ys = zip(*points)
    return min(xs) - reach, min(ys) - reach, max(xs) + reach, max(ys) + reach
def box_corners(points): return hull([(p[0], q[1]) for p in points for q in points])
def chords(a, b, centre):
    """The chords of a counter-clockwise arc."""
    radius, pieces, lines = isqrt(dot(centre, a, a)), [(a, b)], []
    while pieces:
        a, b = pieces.pop()
        length_2 = dot(a, b, b)
        # Up to a quarter turn, an arc leaves its chord by less than L^2 / 6R. The corners are right to 4 units.
        if cross(centre, a, b) > 0 and dot(centre, a, b) >= 0 and length_2 < (CHORD - 4) * 6 * radius:
            lines.append((a, b))
            continue
        length = isqrt(length_2 << 40)  # in 2^-20 units; the middle of the arc lies to the right of the chord
        along = lambda c: ((radius * c << 21) + length) // (2 * length)
        middle = (centre[0] + along(b[1] - a[1]), centre[1] + along(a[0] - b[0]))
        pieces += [(a, middle), (middle, b)]
    return lines
def encloses(loop, p):
    """Whether a closed loop of edges runs around p: an odd number of edges crosses the ray from p toward +x."""
    passing = ((a, b, b[1] - a[1]) for a, b, _, _ in loop if (a[1] > p[1]) != (b[1] > p[1]))
    return sum(cross(a, b, p) * rise > 0 for a, b, rise in passing) % 2 == 1

class Region:
    """K at a height: the loops that bound it, whether it is the outside of all loops, and the zones that stand."""
    def __init__(self, loops, outside, zones):
        self.loops, self.outside, self.zones = loops, outside, zones
        # A tree of boxes: each holds an edge, or up to eight boxes.
        self.boxes = [(box(edge[:2], edge[2]), edge) for loop in loops + zones for edge in loop]
        while len(self.boxes) > 8:
            groups = [self.boxes[i:i + 8] for i in range(0, len(self.boxes), 8)]
            self.boxes = [(box([end for b, _ in group for end in (b[:2], b[2:])]), group) for group in groups]
    def holds(self, p):
        inside = sum(encloses(loop, p) for loop in self.loops) % 2 == 1
        return inside != self.outside or any(encloses(zone, p) for zone in self.zones)
    def near(self, shape, reach, band=0):
        """The edges within reach of a convex shape, given by its corners."""
        left, low, right, high = box(shape, reach + max(band, 0))
        sides = list(zip(shape, shape[1:] + shape[:1])) if len(shape) > 2 else [(shape[0], shape[-1])]
        boxes = list(self.boxes)
        while boxes:
            (x0, y0, x1, y1), item = boxes.pop()
            if x1 < left or x0 > right or y1 < low or y0 > high:
                continue
            if type(item) is list:
                boxes += item
                continue
            least = max(reach + item[2] + (band if item[3] else 0), 0)
            inside = len(shape) > 2 and all(cross(p, q, item[0]) >= 0 for p, q in sides)
            if inside or any(segments_near(*item[:2], p, q, least) for p, q in sides):
                yield item

# --- The plan file: postcard encoding. ---
class Payload:
    def __init__(self, data): self.data, self.at = data, 0
    def take(self, count):
        self.at += count
        need(self.at <= len(self.data), "R1: the plan ends in the middle of a value")
        return self.data[self.at - count:self.at]
    def natural(self):
        byte = self.take(1)[0]  # seven bits a byte, the lowest first
        return byte & 127 | self.natural() << 7 if byte > 127 else byte
    def integer(self):
        folded = self.natural()  # the lowest bit is the sign
        return folded >> 1 ^ -(folded & 1)
    def point(self): return self.integer(), self.integer()
    def text(self): return self.take(self.natural())
    def length_mm(self):  # a 64-bit float, mm, as the exact fraction of units
        return Fraction(*struct.unpack("<d", self.take(8))[0].as_integer_ratio()) * 100_000
    def maybe(self, read): return read() if self.take(1)[0] else None
    def many(self, read): return [read() for _ in range(self.natural())]
    def loop(self):
        """A closed loop of edges. The splines and ellipses behind them follow; `keepout verify` compares them."""
        loop, ends = [], []
        for _ in range(self.natural()):
            kind, a, b = self.natural(), self.point(), self.point()
            centre, bound = self.point() if kind else None, self.integer()
            ends += [a, b]
            arc = () if not kind else chords(a, b, centre) if kind == 1 else chords(b, a, centre)
            loop += [(*chord, bound + CHORD, True) for chord in arc] or [(a, b, bound, False)]
        need(loop and ends[1::2] == ends[2::2] + ends[:1], "R1: a contour of the plan is not closed")
        self.many(lambda: (self.many(lambda: (self.point(), self.natural())), self.natural(), self.natural()))
        return loop
def up(length):  # rounded up; a decimal such as 0.1 mm has no exact binary form, so 1e-6 of a unit does not count
    return -((Fraction(1, 1_000_000) - length) // 1)

class Plan:
    """The part of a plan file that the rules need. The finishing passes follow it."""
    def __init__(self, data):
        need(data[:12] == b"KEEPOUT PLAN" and len(data) > 46, "R1: this is no plan file. Give the plan that was run.")
        need(data[12:14] == b"\x0a\x00", "R1: the plan has another version than 10. Use the program of that version.")
        need(hashlib.sha256(data[46:]).digest() == data[14:46], "R1: the plan is damaged. Copy it again.")
        self.hash, self.regions, p = hashlib.sha256(data).hexdigest(), {}, Payload(data[46:])
        skip = lambda count: lambda: p.take(count)
        p.text(), p.take(32), p.text(), p.many(lambda: (p.maybe(p.point), p.text())), p.maybe(skip(24))  # provenance
        p.many(p.natural), p.many(lambda: p.many(skip(16)))  # numbers of contours, curves that were left out
        p.text(), p.take(72), p.text(), p.maybe(p.natural)  # machine: name, figures, a source, spindle speed
        self.three_axes = p.maybe(skip(48)) is not None
        p.maybe(lambda: (p.text(), p.maybe(skip(1)), p.maybe(skip(8)), p.maybe(skip(8)), p.maybe(p.natural),
                         p.maybe(p.natural), p.maybe(skip(8))))  # controller
        inside, radius, stock = p.natural(), p.integer(), p.integer()
        terms = p.many(lambda: (p.text(), p.length_mm(), p.text()))
        resolution = up(sum(size for name, size, _ in terms if name.startswith(b"controller resolution: ")))
        finishing = radius + sum(up(size) for _, size, _ in terms)
        self.jogging = finishing + max(stock, 2 * resolution)
        arcs = sum(max(up(size) - 1, 0) for name, size, _ in terms if name == b"controller arcs")
        self.finishing = {True: finishing, False: finishing - arcs}  # False: the controller gets chords of arcs
        self.loops, self.zones = p.many(p.loop), p.many(p.loop)
        p.maybe(lambda: (p.point(), p.point())), p.natural()  # travel, direction of the cut
        self.around, self.margin, self.height_error = 0 if inside else None, 0, 0  # top of the face around all loops
        self.heights = p.maybe(lambda: self.read_heights(p))
    def read_heights(self, p):
        _, tops, clamps, floor = p.integer(), p.many(lambda: p.maybe(p.integer)), p.integer(), p.integer()
        p.integer(), p.integer(), p.integer(), p.natural() and p.take(8)  # safe, deepest, step down, entry
        terms = p.many(lambda: (p.natural(), p.length_mm()))
        need(len(tops) == len(self.loops), "R1: the plan has not one top for each contour")
        self.margin = sum(up(size) for _, size in terms)
        self.height_error = 2 * up(sum(size for kind, size in terms if kind in (1, 2)))
        # Each loop lies between the face just inside it and the face around it. That one is just inside the innermost
        # of the loops around this loop: the one with the most loops around itself.
        others = [[j for j, other in enumerate(self.loops) if other is not loop and encloses(other, loop[0][0])]
                  for loop in self.loops]
        innermost = [max(each, key=lambda j: len(others[j]), default=None) for each in others]
        return [(top, self.around if j is None else tops[j]) for top, j in zip(tops, innermost)], clamps, floor
    def region(self, lowest):
        """K for a tip that is commanded to this height, less the height margin."""
        key = self.around is not None, True, (True,) * len(self.loops)
        if self.heights:
            z, (tops, clamps, floor) = max(lowest - self.margin, -LATTICE), self.heights
            need(z >= floor, "R3, R4: the tip would be below the table")
            stands = lambda top: top is not None and top > z
            key = stands(self.around), stands(clamps), tuple(stands(one) != stands(other) for one, other in tops)
        if key not in self.regions:
            loops = [loop for loop, bounds in zip(self.loops, key[2]) if bounds]
            self.regions[key] = Region(loops, key[0], self.zones if key[1] else [])
        return self.regions[key]
    @lru_cache(KEPT_MAX)
    def jog(self, boxed, band, to, height, places, lowest, before):
        """Why a jog does not hold (R3), or None. `before` is the target of the motion before it."""
        need(to in places, "R3: the in-flight set does not hold the target")
        need(lowest <= height, "R3: the lowest height of the in-flight set is above the target")
        region = self.region(lowest)
        edge = next(region.near(box_corners(places) if boxed else hull(places), self.jogging, band), None)
        if not edge:
            return "R3: the in-flight set is inside the part" if region.holds(to) else None
        # It begins at rest, at one place. Before it ends, a rise may follow: with two places, and the same target.
        retracts = len(set(places) - {to}) <= (2 if before and before[:2] == to else 1)
        retracts &= not boxed or all(x == to[0] or y == to[1] for x, y in places)
        if retracts and (before is None or lowest >= before[2] - self.height_error):
            if any(region.holds(p) or any(region.near([p], 0)) for p in places):
                return "R3: the retract move begins in the part"
            ways = ((p, edge) for p in places for edge in region.near([p, to], self.jogging))
            edge = next((edge for p, edge in ways if approaches(p, to, *edge[:2])), None)
        return edge and f"R3: the in-flight set {places} comes too near the edge {edge[:2]}"
    @lru_cache(KEPT_MAX)
    def contour(self, boxed, band, arcs, start, to, centre, clockwise, lowest):
        """Why a motion of a contour does not hold (R4), or None."""
        region, reach = self.region(lowest), self.finishing[arcs]
        lines = [(start, to)] if not centre else chords(to, start, centre) if clockwise else chords(start, to, centre)
        shapes = [(list(line), reach + 10 + (band if centre else 0)) for line in lines]
        need(not boxed or not centre, "R4: the axes are not interpolated, and the motion is an arc")
        for shape, reach in shapes + ([(box_corners([start, to]), reach)] if boxed else []):
            for edge in region.near(shape, reach, 0 if centre else band):
                return f"R4: the motion near {shape[0]} comes too near the edge {edge[:2]}"
        return "R4: the motion is inside the part" if region.holds(start) else None

# --- The log: JSON lines. ---
NEEDED = ("keepout_log began plan drawing dialect description simulated offset travel feed_mm_min home "
          "answer_within_ms baud progress operator setting").split()
EVENTS = "received input command job port_lost outcome certificate sent phase tick port_found halt time_limit".split()
MM = "(-?[0-9]+(?:[.][0-9]{1,5})?)"
TEXT = re.compile(f"([$]J=G53G90G21|G1G21G54G90G94|G[23]G17G21G54G90G94)X{MM}Y{MM}(?:Z{MM})?(?:R{MM})?F([0-9]+)\n")
# Texts that move nothing, but for $H: queries, settings, modes, the spindle, a reset.
QUIET = re.compile("[?]|\x18|[$]\n|[$][I$NH]\n|[$]N[01]=G80\n|[$]10=[0-9]+\n|[$]12=[0-9.]+\n|M3S[0-9]+\n|M5\n|"
                   "\x90?G21G90G94G17G40G49G80(?:G50)?G55\nG54\n[$]#\n")
REPORT = re.compile("<(?:Idle|Jog|Run|Hold|Home|Alarm|Door|Check|Sleep|Tool)(?::[0-9]+)?(?:[|][ -9;-{]*:[ -{}~]*)*>")
HEADS = {"line": "G1G21G54G90G94", "clockwise": "G2G17G21G54G90G94", "counterclockwise": "G3G17G21G54G90G94"}
# No rule needs a number with a point or an exponent: it stays text. No field stands twice.
READER = json.JSONDecoder(parse_float=str, parse_constant=int, parse_int=lambda t: t if t == "-0" else int(t),
                          object_pairs_hook=lambda p: need(len(dict(p)) == len(p), "R2: doubled field") or dict(p))
def form(value, needed, optional=()):
    """The value, if it is an object with these fields."""
    given = set(value) if type(value) is dict else {None}
    need(given >= set(needed) and given <= {*needed, *optional}, "R2: a field is missing or unknown")
    return value
def only(value):  # name and value of an object's only field; a word is a name without a value
    return next(iter(value.items())) if type(value) is dict and len(value) == 1 else (str(value), None)
def whole(value, least=-LATTICE, most=LATTICE):
    need(type(value) is int and least <= value <= most, "R2: a number is missing or out of range")
    return value
def points(value, count):
    """A list of 2 * count coordinates, as points."""
    need(type(value) is list and len(value) == 2 * count, "R2: a point has not two coordinates")
    return [(whole(x), whole(y)) for x, y in zip(value[::2], value[1::2])]
def units(text): return int((Fraction(text) * 200_000 + 1) // 2)  # decimal mm; half a unit is rounded up
def language(name, digest):
    """Whether the axes of jogs and of contours are not interpolated, and whether arcs are sent as arcs."""
    if not digest:
        need(name in ("grbl", "grblhal", "zaber", "venus"), "R2: the language is not known")
        return name == "venus", False, name in ("grbl", "grblhal")
    with open(name, "rb") as file:
        text = file.read(LINE_MAX)
    need(hashlib.sha256(text).hexdigest() == digest, f"R2: the file {name!r} is not as it was in the session")
    words = dict(re.findall(b'(?m)^[ \t]*(interpolation|contours|arc_clockwise)[ \t]*=[ \t]*(?:"([a-z]*)|.)', text))
    jogs, contours = (words.get(key, words.get(b"interpolation")) == b"linear" for key in (b"", b"contours"))
    return not jogs, not contours, contours and b"arc_clockwise" in words

class Session:
    """The check of one log, line by line."""
    def __init__(self, plan, band):
        self.plan, self.band, self.number, self.count = plan, band, 0, 0  # numbers of lines and of certificates
        self.line, self.work, self.due, self.before = "", None, None, None  # incomplete line; work offset; due text
    def check(self, file):
        checksum = last = 0
        for line in iter(lambda: file.readline(LINE_MAX), b""):
            if not line.endswith(b"\n") and len(line) < LINE_MAX:
                break
            self.number += 1
            checksum = zlib.crc32(line[18:-1], zlib.crc32(checksum.to_bytes(4, "little")))
            need(line[:18] == b'{"crc":"%08x",' % checksum and line.endswith(b"\n"),
                 "R2: the line does not match its checksum and the line before. Rely on nothing from here on.")
            fields = READER.decode("{" + line[18:-1].decode())
            if self.number == 1:
                self.begin(form(fields, NEEDED, ("dry_run", "travel_mm", "z")))
                continue
            last = whole(form(fields, ["at_us"], ["event"])["at_us"], last, (1 << 64) - 1)
            self.take(fields["event"] if fields.get("event") is not None else "tick")
        need(self.number, "R2: the log has no complete line")
        texts = "texts agree" if self.compared else "texts not compared"
        return f"every rule holds: {self.number} lines, {self.count} certificates, {texts}"
    def begin(self, header):
        need(whole(header["keepout_log"]) == 3, "R2: the log has another version than 3. Use its program.")
        need(header["plan"] == self.plan.hash, "R1: the log is of another plan. Give the plan that was run.")
        z = header.get("z") and form(header["z"], ("zero", "lowest", "highest"))
        need(z or not self.plan.heights, "R1: the plan has heights, and the log states no third axis")
        self.offset = (*points(header["offset"], 1)[0], whole(z["zero"]) if z and self.plan.three_axes else None)
        self.compared = header["dialect"] in ("grbl", "grblhal")
        self.boxed_jogs, self.boxed_contours, self.arcs = language(str(header["dialect"]), header["description"])
    def take(self, event):
        name, value = only(event)
        need(name in EVENTS, "R2: the event is not known")
        phase = form(value, ["phase"], ["fault"])["phase"] if name == "phase" else None
        # A motion that Keepout cannot write ends the session with a fault. Nothing of it is sent.
        need(not self.due or name == "sent" or phase == "faulted", "R5: no text follows the certificate")
        self.due = self.due if name == "sent" else None
        self.before = None if phase == "starting" else self.before
        self.line = "" if name == "port_found" else self.line
        if name == "certificate":
            self.certificate(*only(value))
        if name in ("sent", "received"):
            need(type(value) is str and all(ord(c) < 256 for c in value), "R2: the text is not of bytes")
            if self.compared:
                (self.sent if name == "sent" else self.received)(value)
    def certificate(self, kind, value):
        """R3 or R4. Then the text is due: its head, X, Y, Z, R and F."""
        need(kind in ("jog", "contour"), "R2: the certificate is not known")
        needed, optional = (["to", "set"], ["lowest", "height"]) if kind == "jog" else (["curve"], ["from", "to"])
        feed = whole(form(value, needed + ["feed_mm_min"], optional)["feed_mm_min"], 0, (1 << 32) - 1)
        first, last = (whole(value.get(name, 0)) for name in optional)
        head, centre, radius, work = "$J=G53G90G21", None, None, (0, 0, 0)
        if kind == "jog":
            need(type(value["set"]) is list and len(value["set"]) <= 16, "R2: the set has more than 16 points")
            to, places = points(value["to"], 1)[0], tuple(points(each, 1)[0] for each in value["set"])
            reason = self.plan.jog(self.boxed_jogs, self.band, to, last, places, first, self.before)
        else:
            turn, curve = only(value["curve"])
            need(turn in HEADS and type(curve) is list, "R2: the curve is not known")
            start, to = points(curve if turn == "line" else curve and curve[0], 2)
            if turn != "line":
                centre, = points(curve[-1], 1)
                radius, other = isqrt(dot(centre, start, start)), dot(centre, to, to)
                need(len(curve) == 2 and start != to and 64 <= radius <= LATTICE
                     and (radius - 1) ** 2 <= other <= (radius + 2) ** 2, "R2: the arc is not on its circle")
            head, work = HEADS[turn], self.work or (LATTICE,) * 3  # without a work offset no text is right
            reason = self.plan.contour(self.boxed_contours, self.band, self.arcs, start, to, centre,
                                       turn == "clockwise", min(first, last))
        need(reason is None, reason)
        self.before, self.count = (*to, last), self.count + 1
        x, y, z = (None if o is None else c + o - w for c, o, w in zip((*to, last), self.offset, work))
        self.due = (head, x, y, None if centre and first == last else z, radius, feed) if self.compared else None
    def sent(self, text):
        match = TEXT.fullmatch(text)
        if self.due or match:
            said = match and (match[1], *(each and units(each) for each in match.groups()[1:5]), int(match[6]))
            need(said and said == self.due, f"R5: the text {text!r} does not say what a certificate says")
            self.due = None
        need(match or QUIET.fullmatch(text), f"R5: the text {text!r} may move the machine")
        self.work = None if "$#" in text else self.work
    def received(self, text):
        *lines, rest = (self.line + text.replace("\r", "")).split("\n")  # for the work offset in the reports
        self.line = rest[:257]
        for line in lines:
            found = re.findall("[|]WCO:([^|]+)[|>]", line) if len(line) <= 256 and REPORT.fullmatch(line) else []
            numbers = found[0].split(",")[:2 if self.offset[2] is None else 3] if len(found) == 1 else ["-"]
            if all(re.fullmatch(" *-?[0-9]+([.][0-9]*)? *", each) for each in numbers):
                self.work = (*map(units, numbers), 0)[:3]

def main(arguments):
    band, plan, code = 0, None, 0
    if arguments[:1] == ["--band"] and re.fullmatch("-?[0-9]{1,6}", "".join(arguments[1:2])):
        band, arguments = int(arguments[1]), arguments[2:]
    if len(arguments) < 2 or arguments[0].startswith("-"):
        return print("usage: check_log.py [--band N] PLAN LOG [LOG ...]", file=sys.stderr) or 2
    for path in arguments:
        session = Session(plan, band)
        try:
            with open(path, "rb") as file:
                plan, text = (plan, session.check(file)) if plan else (Plan(file.read(PLAN_MAX)), "the plan is intact")
            print(f"{path}: {text}")
        except (Fault, ValueError, ArithmeticError, RecursionError, OSError) as error:
            if isinstance(error, OSError) and not session.number:
                return print(f"{path}: {error.strerror}. Check the path.", file=sys.stderr) or 2
            reason = error if isinstance(error, Fault) else f"R{2 if plan else 1}: wrong form: {error}"
            print(f"{path}: line {session.number}: {reason}" if plan else f"{path}: {reason}")
            code = 5
            if plan is None:
                break
    return code

if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
