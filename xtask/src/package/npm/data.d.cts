/** A JSON Schema, draft 2020-12. */
export interface JsonSchema {
  readonly [keyword: string]: unknown;
}

/** The names of all schemas, bundles and test vectors. */
export interface Manifest {
  /** The version of the package. */
  readonly version: string;
  /** The packages with a bundle, such as `px4`. */
  readonly bundles: readonly string[];
  /** The messages and types with a schema, such as `px4/FailsafeFlags`. */
  readonly schemas: readonly string[];
  /** The messages and types with test vectors. */
  readonly vectors: readonly string[];
}

/** The test vectors of a message or type: valid and invalid values. */
export interface Vectors {
  /** The version of the file format. */
  readonly form: 1;
  /** The name of the message or type, such as `px4/FailsafeFlags`. */
  readonly type: string;
  /** The `MESSAGE_VERSION` of a PX4 message. */
  readonly version?: number;
  /** PX4's hash of the fields. */
  readonly hash?: number;
  /** ROS's hash of the type. */
  readonly type_hash?: string;
  /** The address of the JSON Schema. */
  readonly schema: string;
  readonly cases: readonly Vector[];
}

/** A test vector. */
export interface Vector {
  /** The permanent id of the case in its file. Adding fields to the message doesn't change the id. */
  readonly id: string;
  /** The description of the case. */
  readonly description: string;
  /** True if the value violates no rule. */
  readonly valid: boolean;
  /** The id of the violated rule. */
  readonly rule?: string;
  /** The class of an error code. */
  readonly class?: string;
  /** The severity of an error code. */
  readonly severity?: string;
  /** The value as JSON. Integers beyond 2^53 are rounded, as by `JSON.parse`. */
  readonly json?: unknown;
  /** The decoded value as JSON. Present only if re-encoding it produces different bytes. */
  readonly decoded?: unknown;
  /** The uORB payload, hexadecimal. */
  readonly uorb?: string;
  /** The CDR payload with its header, hexadecimal. */
  readonly cdr?: string;
}

/** Returns the names of all schemas, bundles and test vectors. */
export declare function manifest(): Manifest;

/** Returns the JSON Schema of a message or type, such as `px4/FailsafeFlags`. The schema may refer to other schemas. */
export declare function schema(name: string): JsonSchema;

/** Returns one JSON Schema with all messages and types of a package, such as `px4`. It refers to no other schema. */
export declare function bundle(name: string): JsonSchema;

/** Returns the test vectors of a message or type, such as `px4/FailsafeFlags`. */
export declare function vectors(name: string): Vectors;
