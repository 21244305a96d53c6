#pragma once

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/common/content.hpp"
#include "tests/voxelserver/data/sqlite/database.hpp"

namespace terravox::test {

/// A store's fishnet.gpkg, made with the grabber's own migrations, so that both programs are tested
/// against one schema.
class Fishnet : public Database {
public:
    explicit Fishnet(const std::filesystem::path& store) : Database(file_in(store)) {
        run("PRAGMA journal_mode = WAL; BEGIN");
        int version = 0;
        for (const auto& file : migrations()) {
            run(read_content(file));
            run("INSERT INTO terravox_schema VALUES (" + std::to_string(++version) +
                ", 'test', '2026-01-01T00:00:00.000Z')");
        }
        run("COMMIT");
    }

    /// @param columns and values in addition to those that every square of si-lss has, such as ",
    /// state" and ", 'failed'"
    void add(const std::string& name, const std::string& state, const std::string& columns = "",
             const std::string& values = "") {
        run("INSERT INTO squares (source, grid, name, state, urls, crs, class_table, licence, "
            "attribution, known_at" +
            columns + ") VALUES ('si-lss', 'si-lss', '" + name + "', '" + state +
            "', '[]', 'EPSG:3794', 'si-lss', 'CC BY 4.0', 'ARSO \xc5\xbd', "
            "'2026-01-01T00:00:00.000Z'" +
            values + ")");
    }

    /// With a file of 123 points that was verified.
    void add_verified(const std::string& name, const std::string& path, int bytes = 5,
                      const std::string& state = "verified") {
        add(name, state,
            ", file_path, file_bytes, file_sha256, point_count, min_x, min_y, min_z, max_x, max_y, "
            "max_z, verified_at",
            ", '" + path + "', " + std::to_string(bytes) +
                ", '00', 123, 1, 2, 3.5, 4, 5, 6, '2026-01-01T00:00:00.000Z'");
    }

    void add_failed(const std::string& name, const std::string& message) {
        add(name, "failed", ", error_code, error_message, error_at",
            ", 'HTTP', '" + message + "', '2026-01-01T00:00:00.000Z'");
    }

    [[nodiscard]] static std::vector<std::filesystem::path> migrations() {
        std::vector<std::filesystem::path> out;
        for (const auto& entry :
             std::filesystem::directory_iterator(TERRAVOX_SOURCE_DIR "/grabber/migrations"))
            out.push_back(entry.path());
        std::sort(out.begin(), out.end());
        return out;
    }

private:
    static std::filesystem::path file_in(const std::filesystem::path& store) {
        std::filesystem::create_directories(store);
        return store / "fishnet.gpkg";
    }
};

}  // namespace terravox::test
