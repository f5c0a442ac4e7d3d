// One canvas, one camera, two views: what turns one side turns the other.
import * as three from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import type { Surfaces } from '../data/surface.ts';
import { createBody, type Body, type Look } from './body.ts';

export type Side = 0 | 1;

export interface Stage {
  setBody(points: Float32Array, surfaces: Surfaces): void;
  show(side: Side, look: Look): void;
  resetView(): void;
  turn(right: number, up: number): void; // rad
  zoom(factor: number): void;
}

interface View {
  x: number;
  y: number; // from the top
  width: number;
  height: number;
}

const background = 0xf3f1ed;

const nameHeight = 68; // what stands above each view: the model and a line about it

/** Below what is written, beside each other, or in a canvas that is high one below the other. [CSS pixels] */
function views(width: number, height: number): [View, View] {
  const isWide = width >= height;
  const view = { width: isWide ? width / 2 : width, height: Math.max((isWide ? height : height / 2) - nameHeight, 1) };
  const second = isWide ? { x: width / 2, y: nameHeight } : { x: 0, y: height / 2 + nameHeight };
  return [{ x: 0, y: nameHeight, ...view }, { ...second, ...view }];
}

/** How far the camera has to be for all points to be in the middle 86 % of its view. */
function distanceToSee(points: Float32Array, centre: three.Vector3, direction: three.Vector3, camera: three.PerspectiveCamera): number {
  const right = new three.Vector3().crossVectors(camera.up, direction).normalize();
  const up = new three.Vector3().crossVectors(direction, right);
  const upwards = 0.86 * Math.tan((camera.fov * Math.PI) / 360);
  const point = new three.Vector3();
  let distance = 0;
  for (let i = 0; i < points.length; i += 3) {
    point.fromArray(points, i).sub(centre);
    const needed = Math.max(Math.abs(point.dot(up)), Math.abs(point.dot(right)) / camera.aspect) / upwards;
    distance = Math.max(distance, needed + point.dot(direction));
  }
  return distance || 1;
}

/** @param onPick  called with the number of the node that was clicked, or null beside the body */
export function createStage(canvas: HTMLCanvasElement, onPick: (node: number | null) => void): Stage {
  const renderer = new three.WebGLRenderer({ canvas, antialias: true });
  renderer.setClearColor(background);
  renderer.autoClear = false;
  const camera = new three.PerspectiveCamera(32, 1, 0.001, 100);
  camera.up.set(0, 0, 1);
  const controls = new OrbitControls(camera, canvas);
  const sphere = new three.Sphere(new three.Vector3(), 1);
  let bodies: [Body, Body] | null = null;
  let nodes = new Int32Array();
  let places = new Float32Array(); // at rest
  let wasMoved = false;
  let isAsked = false;

  const layout = () => views(canvas.clientWidth, canvas.clientHeight);

  function draw(): void {
    isAsked = false;
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
    renderer.setPixelRatio(window.devicePixelRatio);
    renderer.setSize(canvas.clientWidth, canvas.clientHeight, false);
    const [view] = layout();
    camera.aspect = view.width / Math.max(view.height, 1);
    camera.updateProjectionMatrix();
    if (!wasMoved) resetView();
    draw(); // at once: a canvas that was resized is empty
  }

  function pick(event: PointerEvent): void {
    const box = canvas.getBoundingClientRect();
    const [x, y] = [event.clientX - box.left, event.clientY - box.top];
    const side = layout().findIndex((v) => x >= v.x && x < v.x + v.width && y >= v.y && y < v.y + v.height);
    const view = layout()[side];
    const body = bodies?.[side];
    if (!view || !body) return;
    const ray = new three.Raycaster();
    ray.setFromCamera(new three.Vector2((2 * (x - view.x)) / view.width - 1, 1 - (2 * (y - view.y)) / view.height), camera);
    const hit = ray.intersectObject(body.outside)[0];
    if (!hit?.face) return onPick(null);
    const vertices = body.outside.geometry.getAttribute('position');
    const corners = [hit.face.a, hit.face.b, hit.face.c].map((vertex) => ({
      vertex,
      distance: new three.Vector3().fromBufferAttribute(vertices as three.BufferAttribute, vertex).distanceTo(hit.point),
    }));
    onPick(nodes[corners.sort((a, b) => a.distance - b.distance)[0]!.vertex]!);
  }

  let pressed: PointerEvent | null = null;
  canvas.addEventListener('pointerdown', (event) => (pressed = event));
  canvas.addEventListener('pointerup', (event) => {
    const isClick = pressed && Math.hypot(event.clientX - pressed.clientX, event.clientY - pressed.clientY) < 4;
    if (isClick && event.button === 0) pick(event);
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
    resetView,
    turn(right, up) {
      wasMoved = true;
      const offset = camera.position.clone().sub(controls.target);
      const sideways = new three.Vector3().crossVectors(camera.up, offset).normalize();
      const elevation = Math.asin(offset.z / offset.length());
      const limit = Math.PI / 2 - 0.02;
      const raise = Math.min(Math.max(elevation + up, -limit), limit) - elevation;
      offset.applyAxisAngle(sideways, -raise).applyAxisAngle(camera.up, right);
      camera.position.copy(controls.target).add(offset);
      controls.update();
    },
    zoom(factor) {
      wasMoved = true;
      camera.position.sub(controls.target).multiplyScalar(factor).add(controls.target);
      controls.update();
    },
  };
}
