// A needle inside a body, seen through it, with its target as it was planned and as it is.
import * as three from 'three';
import { pageColours } from './page_colours.ts';

type Vector = readonly [number, number, number];

export interface NeedleMark {
  tip: Vector; // [m]
  handle: Vector; // the end outside [m]
  radius: number; // [m]
  planned: Vector; // the target at rest [m]
  target: Vector; // where it is now [m]
}

export interface NeedleInScene {
  object: three.Object3D;
  show(mark: NeedleMark | null): void;
  free(): void;
}

const up = new three.Vector3(0, 1, 0);
const thinnest = 0.004; // of the size of the body: a needle to scale would be a hair
const pointed = 6; // length of the point over the radius

/** @param size  of the body [m] */
export function createNeedle(size: number): NeedleInScene {
  const ink = (color: number, opacity = 1) => new three.MeshBasicMaterial({ color, opacity, depthTest: false, transparent: true, toneMapped: false });
  const [steel, hub, was, now] = [ink(0xffffff), ink(0x1f6fb5), ink(0xffffff, 0.9), ink(0x0a8f3c, 0.95)];
  // From the tip at the origin, up to the handle.
  const shaft = new three.Mesh(new three.CylinderGeometry(1, 1, 1, 16).translate(0, 0.5, 0), steel);
  const point = new three.Mesh(new three.ConeGeometry(1, 1, 16).translate(0, -0.5, 0).rotateX(Math.PI), steel);
  const grip = new three.Mesh(new three.CylinderGeometry(1, 1, 1, 16).translate(0, 0.5, 0), hub);
  // Steel is dark on a light page and light on a dark one.
  shaft.onBeforeRender = ({ domElement }) => void steel.color.set(pageColours(domElement.parentElement!).ink);
  const needle = new three.Group();
  needle.add(shaft, point, grip);
  const planned = new three.Mesh(new three.SphereGeometry(0.014 * size, 24, 16), was);
  const target = new three.Mesh(new three.SphereGeometry(0.009 * size, 24, 16), now);
  [planned, target, shaft, point, grip].forEach((part, i) => (part.renderOrder = 6 + i)); // after the body, which may be glass
  const object = new three.Group();
  object.add(needle, planned, target);
  object.visible = false;

  return {
    object,
    show(mark) {
      object.visible = mark !== null;
      if (!mark) return;
      const tip = new three.Vector3(...mark.tip);
      const along = new three.Vector3(...mark.handle).sub(tip);
      const length = along.length();
      needle.position.copy(tip);
      needle.quaternion.setFromUnitVectors(up, along.divideScalar(length || 1));
      const radius = Math.max(mark.radius, 0.5 * thinnest * size);
      const head = pointed * radius, hold = 0.06 * size;
      point.scale.set(radius, head, radius);
      shaft.position.set(0, head, 0);
      shaft.scale.set(radius, Math.max(length - head, head), radius);
      grip.position.set(0, length, 0);
      grip.scale.set(2.4 * radius, hold, 2.4 * radius);
      planned.position.set(...mark.planned);
      target.position.set(...mark.target);
    },
    free() {
      for (const part of [shaft, point, grip, planned, target]) part.geometry.dispose();
      for (const material of [steel, hub, was, now]) material.dispose();
    },
  };
}
