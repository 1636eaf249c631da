/** A JSON Schema, draft 2020-12. */
export interface JsonSchema {
  readonly [keyword: string]: unknown;
}

/** The names of all that there is. */
export interface Manifest {
  /** The version of the package. */
  readonly version: string;
  /** The packages that there is a bundle of, such as `px4`. */
  readonly bundles: readonly string[];
  /** The messages and types that there is a schema of, such as `px4/FailsafeFlags`. */
  readonly schemas: readonly string[];
  /** The messages and types that there are test vectors of. */
  readonly vectors: readonly string[];
}

/** Test vectors of a message or type: values that it has and values that it doesn't have. */
export interface Vectors {
  /** The version of this form. */
  readonly form: 1;
  /** The message or type, after its package. */
  readonly type: string;
  /** The message's version, as PX4 counts it. */
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
  /** Names the case within its file. It stays when fields are added. */
  readonly id: string;
  /** What is tried, in words. */
  readonly description: string;
  /** Whether no rule is broken. */
  readonly valid: boolean;
  /** The id of the rule that is broken. */
  readonly rule?: string;
  /** The class of an error code. */
  readonly class?: string;
  /** The severity of an error code. */
  readonly severity?: string;
  /** The value as JSON. Integers beyond 2^53 are their neighbours here, as `JSON.parse` reads them. */
  readonly json?: unknown;
  /** What the bytes decode to, where no writer writes such bytes. */
  readonly decoded?: unknown;
  /** The payload of uORB, in hexadecimal. */
  readonly uorb?: string;
  /** The payload in CDR with its header, in hexadecimal. */
  readonly cdr?: string;
}

/** The names of all schemas, bundles and vectors. */
export declare function manifest(): Manifest;

/** The JSON Schema of a message or type, such as `px4/FailsafeFlags`. It refers to others beside it. */
export declare function schema(name: string): JsonSchema;

/** The JSON Schemas of a package, such as `px4`, as one that needs no other. */
export declare function bundle(name: string): JsonSchema;

/** The test vectors of a message or type, such as `px4/FailsafeFlags`. */
export declare function vectors(name: string): Vectors;
