// Adapter for the npm package jsonschema, which supports drafts up to 7.

import { Validator } from "jsonschema";

import { serve } from "../protocol.js";

await serve("jsonschema", (documents) => {
  const validator = new Validator();
  for (const { text } of documents.values()) {
    validator.addSchema(JSON.parse(text));
  }
  return (schema) => (text) => {
    const { valid, errors } = validator.validate(JSON.parse(text), { $ref: schema });
    return { valid, message: errors[0]?.stack };
  };
});
