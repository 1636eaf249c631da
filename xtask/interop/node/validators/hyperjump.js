// @hyperjump/json-schema for draft 2020-12.

import { registerSchema, validate } from "@hyperjump/json-schema/draft-2020-12";

import { serve } from "../protocol.js";

await serve("@hyperjump/json-schema", (documents) => {
  for (const { text } of documents.values()) {
    registerSchema(JSON.parse(text));
  }
  return async (schema) => {
    const judge = await validate(schema);
    return (text) => ({ valid: judge(JSON.parse(text)).valid });
  };
});
