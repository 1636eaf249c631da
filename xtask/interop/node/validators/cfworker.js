// @cfworker/json-schema for draft 2020-12: it compiles nothing, so that it runs where no code may be made at run time.

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
