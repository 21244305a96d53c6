#include "voxelserver/out/country/workload.hpp"

#include <algorithm>
#include <list>
#include <utility>

#include "common/voxel/fingerprint.hpp"
#include "common/voxel/world.hpp"
#include "voxelserver/make/voxelize/world/world_facts.hpp"
#include "voxelserver/make/worlds/lidar/lidar_kind.hpp"

namespace terravox::country {
namespace {

std::uint64_t to_key(std::int32_t bx, std::int32_t bz) noexcept {
    return static_cast<std::uint64_t>(static_cast<std::uint32_t>(bx)) << 32 |
           static_cast<std::uint32_t>(bz);
}

/// A folder of decoded squares that drops those used longest ago, as store::SquareFolder does.
class Scratch {
public:
    Scratch(const Survey& survey, std::uint64_t limit) : m_survey(survey), m_limit(limit) {}

    void use(std::size_t square, Workload& work) {
        if (const auto there = m_places.find(square); there != m_places.end()) {
            m_order.splice(m_order.end(), m_order, there->second);
            return;
        }
        const SurveySquare& decoded = m_survey.squares()[square];
        ++work.squares;
        work.points += static_cast<double>(decoded.points);
        m_places[square] = m_order.insert(m_order.end(), square);
        m_bytes += decoded.scratch_bytes();
        while (m_bytes > m_limit && m_order.size() > 1) {
            m_bytes -= m_survey.squares()[m_order.front()].scratch_bytes();
            m_places.erase(m_order.front());
            m_order.pop_front();
        }
        work.scratch_bytes = std::max(work.scratch_bytes, m_bytes);
    }

private:
    const Survey& m_survey;
    const std::uint64_t m_limit;
    std::uint64_t m_bytes = 0;
    std::list<std::size_t> m_order;  ///< used longest ago first
    std::unordered_map<std::size_t, std::list<std::size_t>::iterator> m_places;
};

double overlap(std::int32_t a0, std::int32_t a1, std::int32_t b0, std::int32_t b1) noexcept {
    return std::max(0.0,
                    static_cast<double>(std::min(a1, b1)) - static_cast<double>(std::max(a0, b0)));
}

}  // namespace

Survey::Survey(std::vector<SurveySquare> squares, std::int32_t edge)
    : m_squares(std::move(squares)), m_edge(edge) {
    for (std::size_t i = 0; i < m_squares.size(); ++i) {
        const grid::ColumnRect reach = m_squares[i].bounds.grown(kHalo_voxels);
        for (std::int32_t bz = voxel::floor_div(reach.min_z, edge);
             bz <= voxel::floor_div(reach.max_z - 1, edge); ++bz)
            for (std::int32_t bx = voxel::floor_div(reach.min_x, edge);
                 bx <= voxel::floor_div(reach.max_x - 1, edge); ++bx)
                m_read_by[to_key(bx, bz)].push_back(i);
    }
}

grid::ColumnRect Survey::to_rect(const exports::Columns::At& column) const noexcept {
    return {column.bx * m_edge, column.bz * m_edge, (column.bx + 1) * m_edge,
            (column.bz + 1) * m_edge};
}

std::vector<std::size_t> Survey::read_by(const exports::Columns::At& column) const {
    const auto found = m_read_by.find(to_key(column.bx, column.bz));
    return found == m_read_by.end() ? std::vector<std::size_t>{} : found->second;
}

double Survey::covered(const exports::Columns::At& column) const {
    const grid::ColumnRect of = to_rect(column);
    double sum = 0;
    for (const std::size_t i : read_by(column)) {
        const grid::ColumnRect& square = m_squares[i].bounds;
        sum += overlap(of.min_x, of.max_x, square.min_x, square.max_x) *
               overlap(of.min_z, of.max_z, square.min_z, square.max_z);
    }
    return std::min(sum, static_cast<double>(m_edge) * static_cast<double>(m_edge));
}

Workload measure_workload(const Survey& survey, const exports::Columns& columns, std::size_t first,
                          std::size_t end, std::uint64_t scratch_bytes) {
    Workload out;
    Scratch scratch(survey, scratch_bytes);
    for (std::size_t i = first; i < end; ++i) {
        const exports::Columns::At at = columns.at(i);
        ++out.columns;
        out.covered += survey.covered(at);
        for (const std::size_t square : survey.read_by(at))
            scratch.use(square, out);
    }
    return out;
}

OpenedCountry::OpenedCountry(const worlds::WorldOptions& options, const exports::Selection& part)
    : m_world(voxelize::open_lidar_world(worlds::lidar_world_options(options), m_times)),
      m_part(exports::make_part(m_world->info(), part)) {}

std::string OpenedCountry::fingerprint() const {
    const voxel::BoxRange all = voxel::boxes_over(m_world->info().bounds, 0);
    return voxel::to_hex(
        m_world->fingerprint({all.min.bx - 1, all.min.bz - 1, all.max.bx + 1, all.max.bz + 1}));
}

std::string OpenedCountry::fingerprint_of_all_boxes() const {
    const voxelize::InputFingerprints& of = m_world->facts().fingerprints;
    voxel::ByteWriter out;
    out.add(of.everywhere);
    out.add(of.palette);
    return voxel::to_hex(out.fingerprint());
}

std::vector<SurveySquare> OpenedCountry::squares() const {
    std::vector<SurveySquare> out;
    for (const voxelize::SquareInfo& square : m_world->facts().squares)
        out.push_back({square.bounds, square.points});
    return out;
}

}  // namespace terravox::country
