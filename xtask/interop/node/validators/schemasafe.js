// @exodus/schemasafe for draft 2020-12, which reads the texts of instances itself. It wants to be told that it may look at
// contentEncoding, which the specification makes an annotation.

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
