// What is drawn beside a body that is touched: the tool, and the force on it as an arrow.
import * as three from 'three';
import { createNeedle, type NeedleMark } from './needle_mark.ts';

type Vector = readonly [number, number, number];

export interface Marks {
  /** A ball, or two of a grasp, or a square plate whose flat is rounded by the radius [m]. */
  probe: { centre: Vector; radius: number; other?: Vector; plate?: { axis: Vector; half: number } } | null;
  grip: Vector | null; // what is pulled [m]
  arrow: { from: Vector; along: Vector } | null; // [m]
  needle: NeedleMark | null;
}

export interface MarksInScene {
  object: three.Object3D;
  show(marks: Marks): void;
  free(): void;
}

const thickness = 0.006; // of the arrow, as a part of the body
/** What is drawn of a plate behind its flat, over half a side; the one that touches goes on without end. */
const depthOfPlate = 0.5;
const up = new three.Vector3(0, 1, 0);

/** Axes of a plate: two sides of the flat lie as near to an axis of coordinates as they can, and the third one goes in. See core::ToolShape. */
function axesOfPlate(axis: Vector): three.Matrix4 {
  const inwards = new three.Vector3(...axis).normalize();
  const sizes = inwards.toArray().map(Math.abs);
  const along = new three.Vector3().setComponent(sizes.indexOf(Math.min(...sizes)), 1);
  const side = along.addScaledVector(inwards, -along.dot(inwards)).normalize();
  return new three.Matrix4().makeBasis(side, inwards.clone().cross(side), inwards);
}

/** A block whose face is at z = radius, with rounded edges around it, for a half side of 1. @param radius  of the edges over half a side */
function blockOfPlate(radius: number): three.BufferGeometry {
  const square = new three.Shape([[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([x, y]) => new three.Vector2(x, y)));
  return new three.ExtrudeGeometry(square, { depth: depthOfPlate, bevelThickness: radius, bevelSize: radius, bevelSegments: 6 }).translate(0, 0, -depthOfPlate);
}

/** @param size  of the body [m] */
export function createMarks(size: number): MarksInScene {
  // The dent is seen through the probe that makes it.
  const metal = new three.MeshStandardMaterial({ color: 0xb4bfca, roughness: 0.35, transparent: true, opacity: 0.7, depthWrite: false });
  // And a force through the body that it acts on.
  const ink = new three.MeshBasicMaterial({ color: 0xd6281f, depthTest: false, transparent: true, toneMapped: false });

  const probe = new three.Mesh(new three.SphereGeometry(1, 48, 32), metal);
  const other = new three.Mesh(probe.geometry, metal);
  const plate = new three.Mesh(new three.BufferGeometry(), metal);
  let edge = 0; // of the block that there is, over half a side
  const grip = new three.Mesh(new three.SphereGeometry(0.012 * size, 24, 16), ink);
  const shaft = new three.CylinderGeometry(thickness * size, thickness * size, 1, 20).translate(0, 0.5, 0);
  const head = new three.ConeGeometry(2.6 * thickness * size, 7 * thickness * size, 24).translate(0, 3.5 * thickness * size, 0);
  const arrow = new three.Group();
  const [body, tip] = [new three.Mesh(shaft, ink), new three.Mesh(head, ink)];
  arrow.add(body, tip);
  probe.renderOrder = other.renderOrder = plate.renderOrder = 4; // after the body, which may be glass
  grip.renderOrder = body.renderOrder = tip.renderOrder = 5;
  const needle = createNeedle(size);
  const object = new three.Group();
  object.add(probe, other, plate, grip, arrow, needle.object);

  return {
    object,
    show(marks) {
      needle.show(marks.needle);
      plate.visible = !!marks.probe?.plate;
      if (marks.probe?.plate) {
        const { centre, radius, plate: { axis, half } } = marks.probe;
        if (radius / half !== edge) {
          plate.geometry.dispose();
          plate.geometry = blockOfPlate((edge = radius / half));
        }
        plate.setRotationFromMatrix(axesOfPlate(axis));
        plate.position.set(...centre);
        plate.scale.setScalar(half);
      }
      probe.visible = marks.probe !== null && !plate.visible;
      if (marks.probe && probe.visible) {
        probe.position.set(...marks.probe.centre);
        probe.scale.setScalar(marks.probe.radius);
      }
      other.visible = !!marks.probe?.other;
      if (marks.probe?.other) {
        other.position.set(...marks.probe.other);
        other.scale.setScalar(marks.probe.radius);
      }
      grip.visible = marks.grip !== null;
      if (marks.grip) grip.position.set(...marks.grip);
      const along = new three.Vector3(...(marks.arrow?.along ?? [0, 0, 0]));
      const length = along.length();
      arrow.visible = length > 1e-3 * size;
      if (!marks.arrow || !arrow.visible) return;
      arrow.position.set(...marks.arrow.from);
      arrow.quaternion.setFromUnitVectors(up, along.divideScalar(length));
      body.scale.set(1, length, 1);
      tip.position.set(0, length, 0);
    },
    free() {
      needle.free();
      for (const part of [probe, plate, grip, body, tip]) part.geometry.dispose();
      for (const material of [metal, ink]) material.dispose();
    },
  };
}
