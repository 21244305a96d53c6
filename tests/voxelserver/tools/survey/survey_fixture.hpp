#pragma once

#include <laszip/laszip_api.h>

#include <filesystem>
#include <string>
#include <vector>

#include "tests/catch.hpp"
#include "tests/common/content.hpp"
#include "tests/common/temporary_folder.hpp"
#include "voxelserver/tools/survey/survey.hpp"

namespace terravox::survey::test {

using terravox::test::read_content;
using terravox::test::TemporaryFolder;

struct FilePoint {
    double x;
    double y;
    double z;
    double time_s;
    int classification;
    int return_number;
    int return_count;
    int strip;
};

/// Reads all points of a LAS or LAZ file with LASzip itself. @param bounds gets the header's x0,
/// x1, y0, y1, z0, z1
inline std::vector<FilePoint> list_points(const std::filesystem::path& path,
                                          std::vector<double>* bounds = nullptr) {
    laszip_POINTER reader = nullptr;
    laszip_BOOL compressed = 0;
    REQUIRE(laszip_create(&reader) == 0);
    REQUIRE(laszip_open_reader(reader, path.c_str(), &compressed) == 0);
    laszip_header_struct* header = nullptr;
    laszip_point_struct* point = nullptr;
    REQUIRE(laszip_get_header_pointer(reader, &header) == 0);
    REQUIRE(laszip_get_point_pointer(reader, &point) == 0);
    if (bounds != nullptr)
        *bounds = {header->min_x, header->max_x, header->min_y,
                   header->max_y, header->min_z, header->max_z};
    const bool extended = header->point_data_format >= 6;
    const std::uint64_t count =
        extended ? header->extended_number_of_point_records : header->number_of_point_records;
    std::vector<FilePoint> points;
    for (std::uint64_t i = 0; i < count; ++i) {
        REQUIRE(laszip_read_point(reader) == 0);
        points.push_back({point->X * header->x_scale_factor + header->x_offset,
                          point->Y * header->y_scale_factor + header->y_offset,
                          point->Z * header->z_scale_factor + header->z_offset, point->gps_time,
                          extended ? point->extended_classification : point->classification,
                          extended ? point->extended_return_number : point->return_number,
                          extended ? point->extended_number_of_returns : point->number_of_returns,
                          point->point_source_ID});
    }
    laszip_close_reader(reader);
    laszip_destroy(reader);
    return points;
}

/// A small square of the place with lake, island, castle foot and street.
inline SurveyOptions small_survey(const std::filesystem::path& folder) {
    SurveyOptions options;
    options.density = 1.0;
    options.square_m = 256;
    options.origin_east_m = 462400;
    options.origin_north_m = 101240;
    options.folder = folder;
    return options;
}

}  // namespace terravox::survey::test
