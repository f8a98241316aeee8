// The part of the ground that the map shows: drag, wheel, pinch, keys.

const PAN = 0.12; // of the map's width, for an arrow key
const ZOOM = 1.5;

class View {
  constructor(extent) {
    this.extent = extent;
    this.width = this.height = 1;
    this.isWhole = true;
    this.centre = [(extent[0] + extent[2]) / 2, (extent[1] + extent[3]) / 2];
    this.scale = 1; // pixels per metre
  }

  resize(width, height) {
    const before = this.wholeScale();
    [this.width, this.height] = [width, height];
    if (this.isWhole) this.whole();
    else this.scale *= this.wholeScale() / before;
  }

  /** Scale at which the whole block is seen. */
  wholeScale() {
    const wide = Math.max(this.extent[2] - this.extent[0], 1);
    const high = Math.max(this.extent[3] - this.extent[1], 1);
    return Math.min((this.width - 96) / wide, (this.height - 84) / high);
  }

  whole() {
    this.isWhole = true;
    this.scale = this.wholeScale();
    const shift = 8 / this.scale; // room for the labels of the grid
    this.centre = [(this.extent[0] + this.extent[2]) / 2 - shift, (this.extent[1] + this.extent[3]) / 2 - shift];
  }

  x(east) { return (east - this.centre[0]) * this.scale + this.width / 2; }
  y(north) { return this.height / 2 - (north - this.centre[1]) * this.scale; }
  east(x) { return (x - this.width / 2) / this.scale + this.centre[0]; }
  north(y) { return (this.height / 2 - y) / this.scale + this.centre[1]; }

  pan(dx, dy) {
    this.isWhole = false;
    const [west, south, right, top] = this.extent;
    this.centre = [
      Math.min(Math.max(this.centre[0] - dx / this.scale, west), right),
      Math.min(Math.max(this.centre[1] + dy / this.scale, south), top),
    ];
  }

  zoom(factor, x = this.width / 2, y = this.height / 2) {
    const fitting = this.wholeScale();
    const scale = Math.min(Math.max(this.scale * factor, fitting / 2), Math.max(fitting * 2e4, 1000));
    const place = [this.east(x), this.north(y)];
    this.scale = scale;
    this.isWhole = false;
    this.centre = [place[0] - (x - this.width / 2) / scale, place[1] + (y - this.height / 2) / scale];
  }

  /** Bring a place into the middle, near enough to see its neighbours. */
  show(east, north, span) {
    this.isWhole = false;
    this.centre = [east, north];
    this.scale = Math.max(this.scale, Math.min(this.width, this.height) / Math.max(span, 1e-3));
  }

  box(margin = 0) {
    return [this.east(-margin), this.north(this.height + margin), this.east(this.width + margin), this.north(-margin)];
  }
}

/** Let pointer, wheel and keys move a view; `acts` says what a click and a frame do. */
function steer(canvas, view, acts) {
  const pointers = new Map();
  let moved = 0, frame = null;
  const at = (event) => {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, at(event));
    moved = 0;
    frame = event.shiftKey ? at(event) : null;
  });
  canvas.addEventListener("pointermove", (event) => {
    const place = at(event), before = pointers.get(event.pointerId);
    if (!before) return acts.hover(...place, event.pointerType);
    moved += Math.hypot(place[0] - before[0], place[1] - before[1]);
    if (frame) acts.frame(frame, place, false);
    else if (pointers.size === 1) view.pan(place[0] - before[0], place[1] - before[1]);
    else pinch(event.pointerId, before, place);
    pointers.set(event.pointerId, place);
    acts.moved();
  });
  function pinch(id, before, place) {
    const other = [...pointers].find(([key]) => key !== id)[1];
    const apart = (one) => Math.hypot(one[0] - other[0], one[1] - other[1]);
    const middle = [(place[0] + other[0]) / 2, (place[1] + other[1]) / 2];
    view.pan((place[0] - before[0]) / 2, (place[1] - before[1]) / 2);
    if (apart(before) > 1) view.zoom(apart(place) / apart(before), ...middle);
  }
  const end = (event) => {
    if (!pointers.delete(event.pointerId) || event.type === "pointercancel") { frame = null; return; }
    const tolerance = event.pointerType === "mouse" ? 4 : 10;
    if (frame && moved > tolerance) acts.frame(frame, at(event), true);
    else if (moved <= tolerance && !pointers.size) acts.click(...at(event), event.pointerType);
    frame = null;
  };
  canvas.addEventListener("pointerup", end);
  canvas.addEventListener("pointercancel", end);
  canvas.addEventListener("pointerleave", () => acts.leave());
  canvas.addEventListener("wheel", (event) => {
    // whoever scrolls past the map is not held up by it
    if (!event.ctrlKey && !event.metaKey && document.activeElement !== canvas) return acts.hint();
    event.preventDefault();
    view.zoom(Math.exp(-event.deltaY * (event.deltaMode ? 0.05 : 0.0015)), ...at(event));
    acts.moved();
  }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    const step = PAN * view.width;
    const keys = {
      ArrowLeft: () => view.pan(step, 0), ArrowRight: () => view.pan(-step, 0),
      ArrowUp: () => view.pan(0, step), ArrowDown: () => view.pan(0, -step),
      "+": () => view.zoom(ZOOM), "=": () => view.zoom(ZOOM), "-": () => view.zoom(1 / ZOOM),
      0: () => view.whole(), Escape: () => acts.clear(),
    };
    if (!keys[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    keys[event.key]();
    acts.moved();
  });
}
