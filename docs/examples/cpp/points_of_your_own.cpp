// Points of one's own, from any instrument or file: here a field with a house, made up. They are
// voxelized like a laser scan, and the heights are printed.
#include <terravox/terravox.hpp>

#include <cstdio>
#include <vector>

namespace {

constexpr int kSide = 40;
constexpr std::uint8_t kGround = 2;  // classes of ASPRS
constexpr std::uint8_t kBuilding = 6;

class Scan final : public terravox::PointSource {
public:
    [[nodiscard]] std::string crs() const override { return "EPSG:3794"; }

    bool next(std::vector<terravox::Point>& batch) override {
        if (m_row == 4 * kSide)
            return false;
        for (int column = 0; column < 4 * kSide; ++column)
            batch.push_back(point(column / 4.0, m_row / 4.0));
        ++m_row;
        return true;
    }

private:
    static terravox::Point point(double east, double north) {
        const bool house = east >= 10 && east < 22 && north >= 12 && north < 20;
        terravox::Point out;
        out.x = 462000 + east;
        out.y = 101000 + north;
        out.z = house ? 307.5 : 300.5;
        out.classification = house ? kBuilding : kGround;
        return out;
    }

    int m_row = 0;
};

}  // namespace

int main() {
    try {
        Scan scan;
        const auto world = terravox::World::voxelize(scan);
        const terravox::Raster heights = world.surface();
        const auto& values = heights.bands.front().values;
        for (std::size_t row = 0; row < heights.rows; row += 4) {
            for (std::size_t column = 0; column < heights.columns; column += 4)
                std::printf("%5.0f", static_cast<double>(values[row * heights.columns + column]));
            std::printf("\n");
        }
        return 0;
    } catch (const terravox::Error& e) {
        std::fprintf(stderr, "%s\n", e.what());
        return 1;
    }
}
