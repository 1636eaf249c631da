// Adapter for @cfworker/json-schema with draft 2020-12. It works in environments without run-time code generation.

import { Validator } from "@cfworker/json-schema";

import { serve } from "../protocol.js";

await serve("@cfworker/json-schema", (documents) => (schema) => {
  const validator = new Validator({ $ref: schema }, "2020-12");
  for (const { text } of documents.values()) {
    validator.addSchema(JSON.parse(text));
  }
  return (text) => {
    const { valid, errors } = validator.validate(JSON.parse(text));
    return { valid, message: errors.at(-1)?.error };
  };
});
