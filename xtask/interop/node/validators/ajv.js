// Adapter for ajv with draft 2020-12, in strict mode, which rejects schemas with unknown keywords.

import Ajv from "ajv/dist/2020.js";

import { serve } from "../protocol.js";

await serve("ajv", (documents) => {
  const ajv = new Ajv({ logger: false });
  for (const { text } of documents.values()) {
    ajv.addSchema(JSON.parse(text));
  }
  return (schema) => {
    const validate = ajv.getSchema(schema);
    return (text) => ({ valid: validate(JSON.parse(text)), message: ajv.errorsText(validate.errors) });
  };
});
