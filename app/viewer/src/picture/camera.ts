// Where the camera is, and which parts of the canvas it fills.
import * as three from 'three';

export interface View {
  x: number;
  y: number; // from the top
  width: number;
  height: number;
}

/** Of what stands below each view: axes and scale, which so never lie on the body. [CSS pixels] */
export const footHeight = 54;

/**
 * Between what is written, beside each other, or in a canvas that is high one below the other. [CSS pixels]
 * @param nameHeight  of what stands above each view
 */
export function viewsOf(width: number, height: number, numViews: 1 | 2, nameHeight: number): View[] {
  if (numViews === 1) return [{ x: 0, y: nameHeight, width, height: Math.max(height - nameHeight - footHeight, 1) }];
  const isWide = width >= height;
  const view = { width: isWide ? width / 2 : width, height: Math.max((isWide ? height : height / 2) - nameHeight - footHeight, 1) };
  const second = isWide ? { x: width / 2, y: nameHeight } : { x: 0, y: height / 2 + nameHeight };
  return [{ x: 0, y: nameHeight, ...view }, { ...second, ...view }];
}

/** How far the camera has to be for all points to be in the middle 86 % of its view. */
export function distanceToSee(points: Float32Array, centre: three.Vector3, direction: three.Vector3, camera: three.PerspectiveCamera): number {
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

/** Turns about a target, not beyond straight from above or below. @param right, up  [rad] */
export function turnCamera(camera: three.Camera, target: three.Vector3, right: number, up: number): void {
  const offset = camera.position.clone().sub(target);
  const sideways = new three.Vector3().crossVectors(camera.up, offset).normalize();
  const elevation = Math.asin(offset.z / offset.length());
  const limit = Math.PI / 2 - 0.02;
  const raise = Math.min(Math.max(elevation + up, -limit), limit) - elevation;
  offset.applyAxisAngle(sideways, -raise).applyAxisAngle(camera.up, right);
  camera.position.copy(target).add(offset);
}

/** Where a reader has put it. [m] */
export interface CameraPlace {
  position: [number, number, number];
  target: [number, number, number];
}

/** The screen as a plane through a point of the scene. */
export interface Screen {
  right: [number, number, number];
  up: [number, number, number];
  metresPerPixel: number; // of CSS
}

/** @param height  of the view [CSS pixels] */
export function screenAt(camera: three.PerspectiveCamera, height: number, point: readonly number[]): Screen {
  camera.updateMatrixWorld();
  const [right, up, back] = [new three.Vector3(), new three.Vector3(), new three.Vector3()];
  camera.matrixWorld.extractBasis(right, up, back);
  const depth = camera.position.clone().sub(new three.Vector3(...point)).dot(back);
  return {
    right: right.toArray(),
    up: up.toArray(),
    metresPerPixel: (2 * depth * Math.tan((camera.fov * Math.PI) / 360)) / height,
  };
}
