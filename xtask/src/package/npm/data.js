export { bundle, manifest, schema, vectors } from "./data.cjs";
