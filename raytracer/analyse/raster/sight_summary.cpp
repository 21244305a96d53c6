#include "raytracer/analyse/raster/sight_summary.hpp"

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "common/voxel/material.hpp"

namespace terravox::analyse {
namespace {

double share(std::uint64_t part, std::uint64_t of) noexcept {
    return of == 0 ? 0 : static_cast<double>(part) / static_cast<double>(of);
}

void count(SeenCells& cells, bool is_seen) noexcept {
    ++cells.all;
    cells.seen += is_seen ? 1 : 0;
}

std::string name_of_material(int number) {
    return std::string(voxel::material_name(static_cast<voxel::Material>(number)));
}

std::string name_of_class(int number) {
    return "class " + std::to_string(number);
}

using ToName = std::string (*)(int);

void add_rows(const SightSummary& summary, const std::map<int, SeenCells>& kinds, ToName to_name,
              std::string& out) {
    for (const auto& [number, cells] : kinds) {
        if (cells.seen == 0)
            continue;
        out += fmt::format("  {:<20} {:10.4f} km2 {:8.1f} % {:12.1f} %\n", to_name(number),
                           summary.km2(cells.seen), 100 * share(cells.seen, summary.cells.seen),
                           100 * share(cells.seen, cells.all));
    }
}

nlohmann::json make_rows(const SightSummary& summary, const std::map<int, SeenCells>& kinds,
                         ToName to_name) {
    nlohmann::json out = nlohmann::json::array();
    for (const auto& [number, cells] : kinds)
        out.push_back({{"number", number},
                       {"name", to_name(number)},
                       {"cells", cells.all},
                       {"seen_cells", cells.seen},
                       {"seen_km2", summary.km2(cells.seen)},
                       {"share_of_seen", share(cells.seen, summary.cells.seen)},
                       {"seen_share", share(cells.seen, cells.all)}});
    return out;
}

}  // namespace

SightSummary make_summary(CellFile& cells, double edge_m) {
    SightSummary out;
    out.cell_m2 = edge_m * edge_m;
    std::vector<float> seen;
    std::vector<float> materials;
    std::vector<float> classes;
    std::vector<float> holes;
    cells.each_block(cells.block_px(), [&](const CellRectangle& area) {
        cells.read("seen", area, seen);
        cells.read("material", area, materials);
        cells.read("class", area, classes);
        cells.read("hole", area, holes);
        for (std::size_t i = 0; i < seen.size(); ++i) {
            out.holes += holes[i] > 0 ? 1 : 0;
            if (seen[i] == core::kNoData)
                continue;
            const bool is_seen = seen[i] > 0;
            count(out.cells, is_seen);
            count(out.by_material[static_cast<int>(materials[i])], is_seen);
            count(out.by_class[static_cast<int>(classes[i])], is_seen);
        }
    });
    return out;
}

std::string make_table(const SightSummary& summary) {
    std::string out = fmt::format("seen: {:.4f} km2 of {:.4f} km2 ({:.1f} %)\n",
                                  summary.km2(summary.cells.seen), summary.km2(summary.cells.all),
                                  100 * share(summary.cells.seen, summary.cells.all));
    out += "  what                  area seen  share of seen  seen of it\n";
    add_rows(summary, summary.by_material, name_of_material, out);
    add_rows(summary, summary.by_class, name_of_class, out);
    return out;
}

std::string to_json(const SightSummary& summary) {
    const nlohmann::json out = {
        {"cell_m2", summary.cell_m2},
        {"cells", summary.cells.all},
        {"seen_cells", summary.cells.seen},
        {"hole_cells", summary.holes},
        {"seen_km2", summary.km2(summary.cells.seen)},
        {"seen_share", share(summary.cells.seen, summary.cells.all)},
        {"materials", make_rows(summary, summary.by_material, name_of_material)},
        {"classes", make_rows(summary, summary.by_class, name_of_class)}};
    return out.dump();
}

}  // namespace terravox::analyse
