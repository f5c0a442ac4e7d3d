// One canvas, one camera, two views: what turns one side turns the other.
import * as three from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import type { Surfaces } from '../data/surface.ts';
import { createBody, nearestVertex, type Body, type BodyParts, type Look, type NodeLabel, type SurfaceLabel } from './body.ts';
import { distanceToSee, screenAt, turnCamera, viewsOf, type CameraPlace, type Screen } from './camera.ts';
import { endsOfArrows, type ConditionsShown } from './conditions.ts';
import { sayWhenLost } from './lost.ts';
import type { Marks } from './marks.ts';
import { createOverlay, write, type Label } from './overlay.ts';
import { pageColours, watchPageColours } from './page_colours.ts';
import { beyond, isNamed, type Cut, type Names } from './section.ts';

export type Side = 0 | 1;

export interface Stage {
  setBody(points: Float32Array, surfaces: Surfaces, parts?: BodyParts): void;
  /** The same nodes with other surfaces and parts; the view stays as it is, and so does the place where it is cut open. */
  replaceBody(points: Float32Array, surfaces: Surfaces, parts: BodyParts): void;
  show(side: Side, look: Look): void;
  /** All that is prescribed is shown at first, if the body came with it. */
  showConditions(shown: ConditionsShown): void;
  /** Vessels that are lines, which are shown at first. */
  showVessels(areShown: boolean): void;
  /** Takes a part of the bodies away; null shows all of them. */
  setCut(cut: Cut | null): void;
  /** Of what is inside: all, or those that a cut goes through. */
  showNames(which: Names): void;
  /** Of what is on the surface, on the side that is seen. */
  showSurfaceNames(areShown: boolean): void;
  mark(side: Side, marks: Marks): void;
  /** Draws something else with the body of a side, until there is another body. It remains the caller's to change and to free. */
  add(side: Side, object: three.Object3D): void;
  /** After a change of what was added. */
  redraw(): void;
  setViews(count: 1 | 2): void;
  /** What is under the pointer. */
  hitAt(event: PointerEvent): (Hit & { side: Side }) | null;
  screenAt(point: readonly number[]): Screen;
  /** Where places [m] are in the first view. @return (N,3): x and y from the corner of the canvas [CSS pixels], and the depth */
  onCanvas(places: Float32Array): Float32Array;
  /** What the wheel does, and two pointers: zoom, or nothing while a tool has hold of the body. */
  setZooming(isZooming: boolean): void;
  resetView(): void;
  turn(right: number, up: number): void; // rad
  zoom(factor: number): void;
  /** Null as long as nobody has turned the view. */
  cameraPlace(): CameraPlace | null;
  setCameraPlace(place: CameraPlace): void;
  /** The picture with so many times the pixels of the screen, and what is written over it as SVG in CSS pixels. */
  picture(times: number): { image: HTMLCanvasElement; overlay: string };
}

/** A place on the outside of a body, as it is drawn. */
export interface Hit {
  point: [number, number, number]; // [m]
  inwards: [number, number, number]; // normal
  triangle: number; // of the outside
  node: number; // the nearest of its corners
}

export interface Hooks {
  /** The node that was clicked, or null beside the body. */
  onPick?(node: number | null): void;
  /** A place of the canvas was clicked [CSS pixels from its corner]. */
  onClick?(x: number, y: number): void;
  /** Whether a press on a body is taken by a tool, so that it does not turn the camera. */
  takesPress?(event: PointerEvent): boolean;
  /** @param seconds  that drawing took */
  onDrawn?(seconds: number): void;
  /** The camera was moved by the reader. */
  onTurned?(): void;
}

const asWideAsHigh = 1.5; // a body from the front

/**
 * @param nameHeight  of what stands above each view: the model and a line about it [CSS pixels]
 * @param viewedFrom  direction in which the camera is at first: from the front and a little above
 */
export function createStage(canvas: HTMLCanvasElement, hooks: Hooks, nameHeight = 68, viewedFrom: readonly [number, number, number] = [0, -1, 0.25]): Stage {
  const renderer = new three.WebGLRenderer({ canvas, antialias: true });
  renderer.autoClear = false;
  renderer.localClippingEnabled = true;
  const overlay = createOverlay(canvas);
  const camera = new three.PerspectiveCamera(32, 1, 0.001, 100);
  camera.up.set(0, 0, 1);
  const controls = new OrbitControls(camera, canvas);
  if (hooks.takesPress) {
    // The left button and one finger may be the tool's.
    controls.mouseButtons.RIGHT = three.MOUSE.ROTATE;
    controls.touches.TWO = three.TOUCH.DOLLY_ROTATE;
  }
  const sphere = new three.Sphere(new three.Vector3(), 1);
  let bodies: [Body, Body] | null = null;
  let nodes = new Int32Array();
  let places = new Float32Array(); // at rest, of all that is to be seen
  let wasMoved = false;
  let isAsked = false;
  let numViews: 1 | 2 = 2;
  let labels: NodeLabel[] = [];
  let surfaceLabels: SurfaceLabel[] = [];
  let hasSurfaceNames = false;
  let names: Names = 'none';
  let isAnatomical = false;
  let cut: Cut | null = null;
  let hasVessels = true; // in sight

  const layout = () => viewsOf(canvas.clientWidth, canvas.clientHeight, numViews, nameHeight);

  const isThere = (place: three.Vector3) => !cut || beyond(cut, place.getComponent(cut.axis)) <= 0;

  /** A name of a part of the surface at the node that is next to the middle of what faces the camera; nothing where hardly any of it does. */
  function onSurface(body: Body, { name, nodes: own, outwards }: SurfaceLabel): Label[] {
    const middle = new three.Vector3(), normal = new three.Vector3();
    const seen = Array.from(own, (node, i) => ({ place: body.placeOf(node), facing: i })).filter(({ place, facing }) => {
      const sight = place.clone().sub(camera.position).normalize();
      return isThere(place) && normal.fromArray(outwards, 3 * facing).dot(sight) < -0.25;
    });
    if (seen.length < Math.max(3, 0.04 * own.length)) return [];
    for (const { place } of seen) middle.addScaledVector(place, 1 / seen.length);
    return [{ name, place: seen.reduce((best, next) => (next.place.distanceTo(middle) < best.place.distanceTo(middle) ? next : best)).place }];
  }

  function draw(): void {
    isAsked = false;
    if (renderer.getContext().isContextLost()) return;
    const start = performance.now();
    const colours = pageColours(canvas.parentElement!);
    renderer.setClearColor(colours.stage);
    renderer.setScissorTest(false);
    renderer.clear();
    renderer.setScissorTest(true);
    const views = layout();
    for (const [side, view] of views.entries()) {
      const bottom = canvas.clientHeight - view.y - view.height;
      renderer.setViewport(view.x, bottom, view.width, view.height);
      renderer.setScissor(view.x, bottom, view.width, view.height);
      const body = bodies?.[side];
      if (!body) continue;
      body.faceLight(camera);
      renderer.render(body.scene, camera);
    }
    if (bodies) {
      const named = bodies.map((body) => [
        ...labels.map((label) => ({ ...label, place: body.placeOf(label.node) })).filter(({ place, reach }) => isNamed(names, cut, place.toArray(), reach)),
        ...(hasSurfaceNames ? surfaceLabels : []).flatMap((label) => onSurface(body, label)),
      ]);
      const { metresPerPixel } = screenAt(camera, views[0]!.height, controls.target.toArray());
      write(overlay, { views, camera, metresPerPixel, isAnatomical, labels: named, arrows: bodies.map((body) => body.arrows().filter(({ from }) => isThere(from))), colours });
    }
    hooks.onDrawn?.((performance.now() - start) / 1000);
  }
  function askForDrawing(): void {
    if (!isAsked) requestAnimationFrame(draw);
    isAsked = true;
  }

  /** As far as the whole body needs. */
  function resetView(): void {
    wasMoved = false;
    const direction = new three.Vector3(...viewedFrom).normalize();
    const distance = distanceToSee(places, sphere.center, direction, camera);
    camera.near = 0.02 * sphere.radius;
    camera.far = 100 * sphere.radius;
    camera.updateProjectionMatrix();
    controls.target.copy(sphere.center);
    camera.position.copy(sphere.center).addScaledVector(direction, distance);
    controls.minDistance = 0.2 * sphere.radius;
    controls.maxDistance = 12 * sphere.radius;
    controls.update();
    askForDrawing();
  }

  function resize(): void {
    if (canvas.clientWidth === 0) return; // hidden
    renderer.setPixelRatio(window.devicePixelRatio);
    renderer.setSize(canvas.clientWidth, canvas.clientHeight, false);
    const view = layout()[0]!;
    camera.aspect = view.width / view.height;
    camera.updateProjectionMatrix();
    if (!wasMoved) resetView();
    draw(); // at once: a canvas that was resized is empty
  }

  function moved(): void {
    wasMoved = true;
    hooks.onTurned?.();
  }

  function zoom(factor: number): void {
    moved();
    camera.position.sub(controls.target).multiplyScalar(factor).add(controls.target);
    controls.update();
  }

  /** The side under the pointer, and the line of sight there. */
  function sightAt(event: PointerEvent): { side: Side; body: Body; ray: three.Raycaster } | null {
    const box = canvas.getBoundingClientRect();
    const [x, y] = [event.clientX - box.left, event.clientY - box.top];
    const side = layout().findIndex((v) => x >= v.x && x < v.x + v.width && y >= v.y && y < v.y + v.height) as Side;
    const view = layout()[side];
    const body = bodies?.[side];
    if (!view || !body) return null;
    const ray = new three.Raycaster();
    ray.setFromCamera(new three.Vector2((2 * (x - view.x)) / view.width - 1, 1 - (2 * (y - view.y)) / view.height), camera);
    return { side, body, ray };
  }

  function hitAt(event: PointerEvent): (Hit & { side: Side }) | null {
    const sight = sightAt(event);
    const hit = sight?.ray.intersectObject(sight.body.outside, false)
      .find(({ point }) => !cut || beyond(cut, point.getComponent(cut.axis)) <= 0);
    if (!sight || !hit?.face) return null;
    const node = nodes[nearestVertex(sight.body.outside, hit)]!;
    const inwards = hit.face.normal.clone().negate().toArray();
    return { side: sight.side, point: hit.point.toArray(), inwards, triangle: hit.faceIndex!, node };
  }

  function nodeAt(event: PointerEvent): number | null {
    const sight = sightAt(event);
    return sight && sight.body.nodeAt(sight.ray);
  }

  function make(points: Float32Array, surfaces: Surfaces, parts: BodyParts): void {
    bodies?.forEach((body) => body.free());
    const body = () => createBody(points, surfaces, 2 * sphere.radius, parts);
    bodies = [body(), body()];
    bodies.forEach((each) => each.showVessels(hasVessels));
    labels = parts.labels ?? [];
    surfaceLabels = parts.surfaceLabels ?? [];
    isAnatomical = parts.isAnatomical ?? false;
    nodes = Int32Array.from(surfaces.outside.nodes);
  }

  let pressed: PointerEvent | null = null;
  // Before the camera hears of it.
  canvas.addEventListener('pointerdown', (event) => {
    pressed = event;
    const isTaken = event.button === 0 && (hooks.takesPress?.(event) ?? false);
    controls.mouseButtons.LEFT = isTaken ? null : three.MOUSE.ROTATE;
    controls.touches.ONE = isTaken ? null : three.TOUCH.ROTATE;
  }, { capture: true });
  canvas.addEventListener('pointerup', (event) => {
    const isClick = pressed && Math.hypot(event.clientX - pressed.clientX, event.clientY - pressed.clientY) < 4;
    if (isClick && event.button === 0) {
      const box = canvas.getBoundingClientRect();
      hooks.onPick?.(nodeAt(event));
      hooks.onClick?.(event.clientX - box.left, event.clientY - box.top);
    }
    pressed = null;
  });
  controls.addEventListener('start', () => (wasMoved = true));
  controls.addEventListener('end', moved);
  controls.addEventListener('change', askForDrawing);
  new ResizeObserver(resize).observe(canvas);
  // A window that goes to another screen may find other pixels there.
  const watchDensity = () =>
    matchMedia(`(resolution: ${window.devicePixelRatio}dppx)`).addEventListener('change', () => (resize(), watchDensity()), { once: true });
  watchDensity();
  watchPageColours(askForDrawing);
  sayWhenLost(canvas, askForDrawing);

  return {
    setBody(points, surfaces, parts = {}) {
      new three.Box3().setFromArray(points).getBoundingSphere(sphere);
      cut = null;
      make(points, surfaces, parts);
      const arrows = parts.conditions ? endsOfArrows(surfaces.outside, points, parts.conditions, 2 * sphere.radius) : [];
      places = Float32Array.from([...points, ...arrows, ...(parts.alsoSeen ?? [])]);
      resetView();
    },
    replaceBody(points, surfaces, parts) {
      make(points, surfaces, parts);
      bodies!.forEach((body) => body.cut(cut));
    },
    show(side, look) {
      bodies?.[side].show(look);
      askForDrawing();
    },
    showConditions(shown) {
      bodies?.forEach((body) => body.showConditions(shown));
      askForDrawing();
    },
    showVessels(areShown) {
      hasVessels = areShown;
      bodies?.forEach((body) => body.showVessels(areShown));
      askForDrawing();
    },
    setCut(next) {
      cut = next;
      bodies?.forEach((body) => body.cut(next));
      askForDrawing();
    },
    showNames(which) {
      names = which;
      askForDrawing();
    },
    showSurfaceNames(areShown) {
      hasSurfaceNames = areShown;
      askForDrawing();
    },
    mark(side, marks) {
      bodies?.[side].mark(marks);
      askForDrawing();
    },
    setViews(count) {
      numViews = count;
      const before = Math.min(camera.aspect, asWideAsHigh);
      resize();
      // Whoever has turned it goes on to see as much of it.
      if (wasMoved) zoom(before / Math.min(camera.aspect, asWideAsHigh));
    },
    add(side, object) {
      bodies?.[side].scene.add(object);
      askForDrawing();
    },
    redraw: askForDrawing,
    onCanvas(points) {
      const view = layout()[0]!;
      camera.updateMatrixWorld();
      const place = new three.Vector3();
      return Float32Array.from({ length: points.length }, (_, i) => {
        if (i % 3 === 0) place.fromArray(points, i).project(camera);
        return i % 3 === 0 ? view.x + ((place.x + 1) / 2) * view.width : i % 3 === 1 ? view.y + ((1 - place.y) / 2) * view.height : place.z;
      });
    },
    hitAt,
    screenAt: (point) => screenAt(camera, layout()[0]!.height, point),
    setZooming: (isZooming) => (controls.enableZoom = isZooming),
    resetView() {
      resetView();
      hooks.onTurned?.();
    },
    turn(right, up) {
      moved();
      turnCamera(camera, controls.target, right, up);
      controls.update();
    },
    zoom,
    cameraPlace: () => (wasMoved ? { position: camera.position.toArray(), target: controls.target.toArray() } : null),
    setCameraPlace({ position, target }) {
      wasMoved = true;
      camera.position.set(...position);
      controls.target.set(...target);
      controls.update();
      askForDrawing();
    },
    picture(times) {
      const before = renderer.getPixelRatio();
      const image = document.createElement('canvas');
      const drawWith = (ratio: number) => {
        renderer.setPixelRatio(ratio); // and the size with it
        draw();
      };
      drawWith(times * before);
      [image.width, image.height] = [canvas.width, canvas.height];
      image.getContext('2d')!.drawImage(canvas, 0, 0); // at once: the canvas keeps nothing
      drawWith(before);
      return { image, overlay: overlay.innerHTML };
    },
  };
}
