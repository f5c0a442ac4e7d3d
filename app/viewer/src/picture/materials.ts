// What a body is made of in the picture.
import * as three from 'three';
import { colourAt, notANumber, quantities, type Colour, type Colouring } from './colour_maps.ts';
import { patchColour } from './patch_colours.ts';
import { colourOfPlace } from './tissue.ts';

export type Skin = 'translucent' | 'solid' | 'flat';
/** Also a thin one, without colours, through which one sees what is inside. */
export type BodySkin = Skin | 'veil';
/** Every colour is the one of the legend. */
export const defaultSkin: Skin = 'flat';
/** What one touches has to be seen as a body, so Live begins with light on it. */
export const liveSkin: Skin = 'solid';

export const mapWidth = 256;

/** Two rows: the map, and what has no lines of equal values: the colour of what is no number. */
function mapTexture(colours: Colour[], filter: three.MagnificationTextureFilter = three.LinearFilter, second = colours.map(() => notANumber)): three.DataTexture {
  const rows = [...colours, ...second].flatMap((colour) => [...colour, 255]);
  const texture = new three.DataTexture(new Uint8Array(rows), colours.length, 2);
  texture.colorSpace = three.SRGBColorSpace;
  texture.magFilter = filter;
  texture.minFilter = filter;
  texture.needsUpdate = true;
  return texture;
}

/**
 * Glass that is thicker where it is seen from the side, so that the shape of the body can be read.
 * @param least, most  opacity seen from the front and from the side
 */
function glassMaterial(least: string, most: string): three.MeshStandardMaterial {
  const glass = new three.MeshStandardMaterial({ roughness: 0.6, transparent: true, depthWrite: false });
  glass.onBeforeCompile = (shader) => {
    shader.fragmentShader = shader.fragmentShader.replace('#include <opaque_fragment>', `
      float facing = abs(dot(normal, normalize(vViewPosition)));
      diffuseColor.a = mix(${most}, ${least}, smoothstep(0.0, 0.75, facing));
      #include <opaque_fragment>`);
  };
  glass.customProgramCacheKey = () => `glass ${least} ${most}`; // the programs differ in these alone
  return glass;
}

/** Without light, so that a colour on the screen is one of the legend; thin lines join equal values, ten to the legend. */
function flatMaterial(): three.MeshBasicMaterial {
  const flat = new three.MeshBasicMaterial({ side: three.DoubleSide, toneMapped: false });
  flat.onBeforeCompile = (shader) => {
    shader.fragmentShader = shader.fragmentShader.replace('#include <opaque_fragment>', `
      float tenths = (vMapUv.x * ${mapWidth}.0 - 0.5) / ${mapWidth - 1}.0 * 10.0;
      float steepness = fwidth(tenths);
      float fromLine = abs(tenths - floor(tenths + 0.5)) / max(steepness, 1e-6);
      bool isInside = tenths > 0.5 && tenths < 9.95 && vMapUv.y < 0.5;
      if (isInside && steepness > 1e-4 && steepness < 0.5)
        outgoingLight *= mix(0.72, 1.0, smoothstep(0.35, 1.0, fromLine));
      #include <opaque_fragment>`);
  };
  return flat;
}

export interface BodyMaterials {
  skins: Record<BodySkin, three.Material>;
  section: three.Material;
  outline: three.LineBasicMaterial;
  depth: three.Material; // how far away glass is
  wound: three.Material; // raw tissue, which no legend has
  unseen: three.Material; // of what is drawn elsewhere
  use(colouring: Colouring): void;
  clip(planes: three.Plane[]): void;
  free(): void;
}

/** @param numPatches  named parts of the surface */
export function createMaterials(numPatches: number): BodyMaterials {
  const mapOf = (colour: (i: number) => Colour, count: number) => Array.from({ length: count }, (_, i) => colour(i));
  const tissue = mapOf((i) => colourOfPlace(i / (mapWidth - 1)), mapWidth);
  const textures = {
    ...Object.fromEntries(quantities.map((q) => [q, mapTexture(mapOf((i) => colourAt(q, i / (mapWidth - 1)), mapWidth))])),
    patches: mapTexture(mapOf(patchColour, Math.max(numPatches, 1)), three.NearestFilter),
    tissue: mapTexture(tissue, three.NearestFilter, tissue),
  } as Record<Colouring, three.DataTexture>;
  const lit = new three.MeshStandardMaterial({ roughness: 0.75, side: three.DoubleSide });
  const glass = glassMaterial('0.5', '0.9');
  const veil = glassMaterial('0.12', '0.45');
  const flat = flatMaterial();
  const section = flatMaterial();
  const outline = new three.LineBasicMaterial({ color: 0x111111, toneMapped: false });
  // Glass shows its front only: this writes how far that is, so that the far side does not shine through.
  const depth = new three.MeshBasicMaterial({ colorWrite: false });
  const wound = new three.MeshStandardMaterial({ color: 0xb4453d, roughness: 0.55, side: three.DoubleSide });
  const unseen = new three.MeshBasicMaterial({ visible: false, side: three.DoubleSide });
  const coloured = [lit, glass, flat, section];
  // A map from the start: to get one later, a material would have to be compiled again.
  for (const material of coloured) material.map = textures.displacement;
  return {
    skins: { translucent: glass, solid: lit, flat, veil },
    section,
    outline,
    depth,
    wound,
    unseen,
    use(colouring) {
      for (const material of coloured) material.map = textures[colouring];
      // Most of a body is at the beginning of the map, which is dark or pale.
      outline.color.set(colouring === 'displacement' ? 0xffffff : 0x111111);
    },
    clip(planes) {
      for (const material of [lit, glass, flat, veil, depth, wound]) material.clippingPlanes = planes;
    },
    free() {
      for (const material of [...coloured, veil, outline, depth, wound, unseen]) material.dispose();
      for (const texture of Object.values(textures)) texture.dispose();
    },
  };
}
