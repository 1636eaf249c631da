// Adapter for @hyperjump/json-schema with draft 2020-12.

import { registerSchema, validate } from "@hyperjump/json-schema/draft-2020-12";

import { serve } from "../protocol.js";

await serve("@hyperjump/json-schema", (documents) => {
  for (const { text } of documents.values()) {
    registerSchema(JSON.parse(text));
  }
  return async (schema) => {
    const check = await validate(schema);
    return (text) => ({ valid: check(JSON.parse(text)).valid });
  };
});
