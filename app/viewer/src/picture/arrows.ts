// Arrows on a surface, many with few draw calls.
import * as three from 'three';

export interface Arrow {
  from: three.Vector3; // [m]
  along: three.Vector3; // [m], as long as it is drawn
}

export interface Arrows {
  object: three.Object3D;
  /** @param arrows  at most as many as there is room for */
  place(arrows: Arrow[]): void;
  clip(planes: three.Plane[]): void;
  free(): void;
}

const up = new three.Vector3(0, 1, 0);
const headPart = 0.35; // of the arrow that is head, at most

/** @param size  of the body [m] */
export function createArrows(room: number, colour: number, size: number): Arrows {
  const radius = 0.0035 * size;
  const headLength = 0.026 * size;
  const ink = new three.MeshStandardMaterial({ color: colour, roughness: 0.7 });
  const shafts = new three.InstancedMesh(new three.CylinderGeometry(radius, radius, 1, 12).translate(0, 0.5, 0), ink, room);
  const heads = new three.InstancedMesh(new three.ConeGeometry(0.32 * headLength, headLength, 16).translate(0, -0.5 * headLength, 0), ink, room);
  const object = new three.Group();
  for (const part of [shafts, heads]) {
    part.frustumCulled = false; // its bounds are those of one arrow
    part.count = 0;
    part.renderOrder = 4; // after the body, which may be glass
    object.add(part);
  }

  return {
    object,
    place(arrows) {
      const [turn, matrix, tip] = [new three.Quaternion(), new three.Matrix4(), new three.Vector3()];
      arrows.forEach(({ from, along }, i) => {
        const length = along.length();
        turn.setFromUnitVectors(up, along.clone().divideScalar(length || 1));
        const head = Math.min(headLength, headPart * length) / headLength;
        shafts.setMatrixAt(i, matrix.compose(from, turn, new three.Vector3(1, Math.max(length - 0.9 * head * headLength, 1e-9), 1)));
        heads.setMatrixAt(i, matrix.compose(tip.copy(from).add(along), turn, new three.Vector3(Math.sqrt(head), head, Math.sqrt(head))));
      });
      for (const part of [shafts, heads]) {
        part.count = arrows.length;
        part.instanceMatrix.needsUpdate = true;
      }
    },
    clip: (planes) => (ink.clippingPlanes = planes),
    free() {
      for (const part of [shafts, heads]) {
        part.geometry.dispose();
        part.dispose();
      }
      ink.dispose();
    },
  };
}
