#include "voxelserver/make/voxelize/columns/survey_bounds.hpp"

namespace terravox::voxelize {

bool SurveyBounds::surrounds(const grid::ColumnRect& rect) const noexcept {
    return std::any_of(m_files.begin(), m_files.end(), [&](const SquareSource& s) {
        return std::any_of(s.islands.begin(), s.islands.end(), [&](const grid::ColumnRect& island) {
            return rect.min_x >= island.min_x && rect.max_x <= island.max_x &&
                   rect.min_z >= island.min_z && rect.max_z <= island.max_z;
        });
    });
}

Grid<char, Window::kMargin> SurveyBounds::around(grid::PatchKey middle) const {
    using Area = Grid<char, Window::kMargin>;
    Area out(0);
    for (const SquareSource& s : m_files)
        for (const grid::ColumnRect& island : s.islands) {
            const int x0 = std::max(island.min_x - middle.x0(), Area::kFirst);
            const int x1 = std::min(island.max_x - middle.x0(), Area::kLast);
            const int z0 = std::max(island.min_z - middle.z0(), Area::kFirst);
            const int z1 = std::min(island.max_z - middle.z0(), Area::kLast);
            for (int z = z0; z < z1 && x0 < x1; ++z)
                std::fill_n(&out.at(x0, z), x1 - x0, char{1});
        }
    return out;
}

}  // namespace terravox::voxelize
