// Adapter for @exodus/schemasafe with draft 2020-12, which parses instances itself. The option contentValidation is
// required for schemas with contentEncoding, although the specification defines it as an annotation.

import { parser } from "@exodus/schemasafe";

import { serve } from "../protocol.js";

await serve("@exodus/schemasafe", (documents) => {
  const schemas = [...documents.values()].map(({ text }) => JSON.parse(text));
  return (schema) => {
    const $schema = "https://json-schema.org/draft/2020-12/schema";
    const parse = parser({ $schema, $ref: schema }, { schemas, mode: "default", contentValidation: true, includeErrors: true });
    return (text) => {
      const { valid, error } = parse(text);
      return { valid, message: error };
    };
  };
});
