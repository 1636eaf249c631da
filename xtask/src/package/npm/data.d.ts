export * from "./data.cjs";
