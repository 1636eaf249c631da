// Adapter for valijson, which supports drafts up to 7. Reads jobs and writes one JSON line for each schema and case; see
// xtask/interop/README.md.

#include <cstdlib>
#include <exception>
#include <fstream>
#include <iostream>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validation_results.hpp>
#include <valijson/validator.hpp>

using nlohmann::json;
using Adapter = valijson::adapters::NlohmannJsonAdapter;

namespace {

// Flushes the line, so that verdicts before a crash are preserved.
void write(const json &line) {
    std::cout << line.dump(-1, ' ', false, json::error_handler_t::replace) << std::endl;
}

json read(const std::string &path) {
    std::ifstream file(path);
    return json::parse(file);
}

// The verdict on one case.
json check(const valijson::Schema &schema, const std::string &text) {
    try {
        const json instance = json::parse(text);
        valijson::ValidationResults results;
        valijson::Validator validator;
        if (validator.validate(schema, Adapter(instance), &results)) {
            return {{"valid", true}};
        }
        valijson::ValidationResults::Error error;
        results.popError(error);
        return {{"valid", false}, {"message", error.description}};
    } catch (const std::exception &error) {
        return {{"error", error.what()}};
    }
}

void run(const json &job, const std::map<std::string, json> &documents) {
    const auto number = job.at("job");
    valijson::Schema schema;
    const json reference = {{"$ref", job.at("schema")}};
    try {
        const auto fetch = [&](const std::string &address) -> const json * {
            const auto document = documents.find(address);
            return document == documents.end() ? nullptr : new json(document->second);
        };
        const auto release = [](const json *document) { delete document; };
        valijson::SchemaParser(valijson::SchemaParser::kDraft7)
            .populateSchema<Adapter>(Adapter(reference), schema, fetch, release);
    } catch (const std::exception &error) {
        write({{"job", number}, {"error", error.what()}});
        return;
    }
    write({{"job", number}});
    std::size_t index = 0;
    for (const auto &text : job.at("cases")) {
        json verdict = check(schema, text.get<std::string>());
        verdict["job"] = number;
        verdict["case"] = index++;
        write(verdict);
    }
}

}  // namespace

int main(int argc, char **argv) {
    if (argc < 2) {
        std::cerr << "usage: valijson FILE\n";
        return EXIT_FAILURE;
    }
    std::map<std::string, json> documents;
    std::vector<json> jobs;
    std::ifstream file(argv[1]);
    for (std::string text; std::getline(file, text);) {
        const json line = json::parse(text);
        if (line.contains("document")) {
            documents[line.at("document")] = read(line.at("path"));
        } else {
            jobs.push_back(line);
        }
    }
    write({{"version", VALIJSON_VERSION}});
    for (const auto &job : jobs) {
        run(job, documents);
    }
}
