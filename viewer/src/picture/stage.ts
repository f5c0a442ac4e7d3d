// One canvas, one camera, two views: what turns one side turns the other.
import * as three from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import type { Surfaces } from '../data/surface.ts';
import { createBody, type Body, type Look } from './body.ts';
import { distanceToSee, screenAt, turnCamera, viewsOf, type Screen } from './camera.ts';
import type { Marks } from './marks.ts';

export type Side = 0 | 1;

export interface Stage {
  setBody(points: Float32Array, surfaces: Surfaces): void;
  show(side: Side, look: Look): void;
  mark(side: Side, marks: Marks): void;
  setViews(count: 1 | 2): void;
  /** What is under the pointer. */
  hitAt(event: PointerEvent): (Hit & { side: Side }) | null;
  screenAt(point: readonly number[]): Screen;
  /** What the wheel does, and two pointers: zoom, or nothing while a tool is held. */
  setZooming(isZooming: boolean): void;
  resetView(): void;
  turn(right: number, up: number): void; // rad
  zoom(factor: number): void;
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
  /** Whether a press on a body is taken by a tool, so that it does not turn the camera. */
  takesPress?(event: PointerEvent): boolean;
  /** @param seconds  that drawing took */
  onDrawn?(seconds: number): void;
}

const background = 0xf3f1ed;
const asWideAsHigh = 1.5; // a body from the front

/** @param nameHeight  of what stands above each view: the model and a line about it [CSS pixels] */
export function createStage(canvas: HTMLCanvasElement, hooks: Hooks, nameHeight = 68): Stage {
  const renderer = new three.WebGLRenderer({ canvas, antialias: true });
  renderer.setClearColor(background);
  renderer.autoClear = false;
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
  let places = new Float32Array(); // at rest
  let wasMoved = false;
  let isAsked = false;
  let numViews: 1 | 2 = 2;

  const layout = () => viewsOf(canvas.clientWidth, canvas.clientHeight, numViews, nameHeight);

  function draw(): void {
    isAsked = false;
    const start = performance.now();
    renderer.setScissorTest(false);
    renderer.clear();
    renderer.setScissorTest(true);
    for (const [side, view] of layout().entries()) {
      const bottom = canvas.clientHeight - view.y - view.height;
      renderer.setViewport(view.x, bottom, view.width, view.height);
      renderer.setScissor(view.x, bottom, view.width, view.height);
      const body = bodies?.[side];
      if (!body) continue;
      body.faceLight(camera);
      renderer.render(body.scene, camera);
    }
    hooks.onDrawn?.((performance.now() - start) / 1000);
  }
  function askForDrawing(): void {
    if (!isAsked) requestAnimationFrame(draw);
    isAsked = true;
  }

  /** From the front and a little above, as far as the whole body needs. */
  function resetView(): void {
    wasMoved = false;
    const direction = new three.Vector3(0, -1, 0.25).normalize();
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

  function zoom(factor: number): void {
    wasMoved = true;
    camera.position.sub(controls.target).multiplyScalar(factor).add(controls.target);
    controls.update();
  }

  function hitAt(event: PointerEvent): (Hit & { side: Side }) | null {
    const box = canvas.getBoundingClientRect();
    const [x, y] = [event.clientX - box.left, event.clientY - box.top];
    const side = layout().findIndex((v) => x >= v.x && x < v.x + v.width && y >= v.y && y < v.y + v.height) as Side;
    const view = layout()[side];
    const body = bodies?.[side];
    if (!view || !body) return null;
    const ray = new three.Raycaster();
    ray.setFromCamera(new three.Vector2((2 * (x - view.x)) / view.width - 1, 1 - (2 * (y - view.y)) / view.height), camera);
    const hit = ray.intersectObject(body.outside)[0];
    if (!hit?.face) return null;
    const vertices = body.outside.geometry.getAttribute('position');
    const corners = [hit.face.a, hit.face.b, hit.face.c].map((vertex) => ({
      vertex,
      distance: new three.Vector3().fromBufferAttribute(vertices as three.BufferAttribute, vertex).distanceTo(hit.point),
    }));
    const node = nodes[corners.sort((a, b) => a.distance - b.distance)[0]!.vertex]!;
    return { side, point: hit.point.toArray(), inwards: hit.face.normal.clone().negate().toArray(), triangle: hit.faceIndex!, node };
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
    if (isClick && event.button === 0) hooks.onPick?.(hitAt(event)?.node ?? null);
    pressed = null;
  });
  controls.addEventListener('start', () => (wasMoved = true));
  controls.addEventListener('change', askForDrawing);
  new ResizeObserver(resize).observe(canvas);
  // A window that goes to another screen may find other pixels there.
  const watchDensity = () =>
    matchMedia(`(resolution: ${window.devicePixelRatio}dppx)`).addEventListener('change', () => (resize(), watchDensity()), { once: true });
  watchDensity();

  return {
    setBody(points, surfaces) {
      bodies?.forEach((body) => body.free());
      new three.Box3().setFromArray(points).getBoundingSphere(sphere);
      bodies = [createBody(points, surfaces, 2 * sphere.radius), createBody(points, surfaces, 2 * sphere.radius)];
      nodes = Int32Array.from(surfaces.outside.nodes);
      places = Float32Array.from(points);
      resetView();
    },
    show(side, look) {
      bodies?.[side].show(look);
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
    hitAt,
    screenAt: (point) => screenAt(camera, layout()[0]!.height, point),
    setZooming: (isZooming) => (controls.enableZoom = isZooming),
    resetView,
    turn(right, up) {
      wasMoved = true;
      turnCamera(camera, controls.target, right, up);
      controls.update();
    },
    zoom,
  };
}
