// What is drawn beside a body that is touched: the tool, and the force on it as an arrow.
import * as three from 'three';
import { createNeedle, type NeedleMark } from './needle_mark.ts';

type Vector = readonly [number, number, number];

export interface Marks {
  probe: { centre: Vector; radius: number; other?: Vector } | null; // a ball, or two of a grasp [m]
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
const up = new three.Vector3(0, 1, 0);

/** @param size  of the body [m] */
export function createMarks(size: number): MarksInScene {
  // The dent is seen through the probe that makes it.
  const metal = new three.MeshStandardMaterial({ color: 0xb4bfca, roughness: 0.35, transparent: true, opacity: 0.7, depthWrite: false });
  // And a force through the body that it acts on.
  const ink = new three.MeshBasicMaterial({ color: 0xd6281f, depthTest: false, transparent: true, toneMapped: false });

  const probe = new three.Mesh(new three.SphereGeometry(1, 48, 32), metal);
  const other = new three.Mesh(probe.geometry, metal);
  const grip = new three.Mesh(new three.SphereGeometry(0.012 * size, 24, 16), ink);
  const shaft = new three.CylinderGeometry(thickness * size, thickness * size, 1, 20).translate(0, 0.5, 0);
  const head = new three.ConeGeometry(2.6 * thickness * size, 7 * thickness * size, 24).translate(0, 3.5 * thickness * size, 0);
  const arrow = new three.Group();
  const [body, tip] = [new three.Mesh(shaft, ink), new three.Mesh(head, ink)];
  arrow.add(body, tip);
  probe.renderOrder = other.renderOrder = 4; // after the body, which may be glass
  grip.renderOrder = body.renderOrder = tip.renderOrder = 5;
  const needle = createNeedle(size);
  const object = new three.Group();
  object.add(probe, other, grip, arrow, needle.object);

  return {
    object,
    show(marks) {
      needle.show(marks.needle);
      probe.visible = marks.probe !== null;
      if (marks.probe) {
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
      for (const part of [probe, grip, body, tip]) part.geometry.dispose();
      for (const material of [metal, ink]) material.dispose();
    },
  };
}
