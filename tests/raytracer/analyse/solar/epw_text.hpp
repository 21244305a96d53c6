#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <sstream>
#include <string>

#include "common/geo/lat_lon.hpp"

namespace terravox::test {

inline constexpr geo::MapPlace kTown{46, 14.5};

/// Light of an hour, Wh/m2.
struct EpwLight {
    double global = 0;
    double beam = 0;
    double diffuse = 0;
};

/// A made-up light for an hour of a plain year, with about the sun of kTown at UTC+1.
inline EpwLight made_up_light(int hour_of_year) {
    constexpr double kRad = 0.017453292519943295;
    const int day = hour_of_year / 24 + 1;
    const int hour = hour_of_year % 24;
    const double declination = 23.45 * kRad * std::sin(2 * 180 * kRad * (284 + day) / 365);
    const double angle = kRad * (15 * (hour + 0.5 - 12) + kTown.lon_deg - 15);
    const double latitude = kTown.lat_deg * kRad;
    const double sine =
        std::max(0.0, std::sin(latitude) * std::sin(declination) +
                          std::cos(latitude) * std::cos(declination) * std::cos(angle));
    const double cloud = std::fmod(hour_of_year * 0.6180339887498949, 1.0);
    EpwLight out;
    out.beam = std::floor((cloud < 0.7 ? 900 * std::sqrt(sine) * (1 - cloud) : 0) + 0.5);
    out.diffuse = std::floor(sine * (100 + 250 * cloud) + 0.5);
    out.global = std::floor(out.beam * sine + out.diffuse + 0.5);
    return out;
}

/// A weather file.
/// @param days 365 or 366
inline std::string epw_text(
    const std::function<EpwLight(int hour_of_year)>& light_at = made_up_light, int days = 365) {
    std::ostringstream out;
    out << "LOCATION,Town,-,SVN,formula,000000,46.0,14.5,1,300\r\n"
           "DESIGN CONDITIONS,0\r\nTYPICAL/EXTREME PERIODS,0\r\nGROUND TEMPERATURES,0\r\n"
           "HOLIDAYS/DAYLIGHT SAVINGS,No,0,0,0\r\nCOMMENTS 1,made up\r\nCOMMENTS 2,\r\n"
           "DATA PERIODS,1,1,Data,Sunday, 1/ 1,12/31\r\n";
    const int lengths[] = {31, days - 337, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
    int index = 0;
    for (int month = 1; month <= 12; ++month)
        for (int day = 1; day <= lengths[month - 1]; ++day)
            for (int hour = 1; hour <= 24; ++hour) {
                const EpwLight light = light_at(index++);
                out << "2001," << month << ',' << day << ',' << hour
                    << ",60,?9?9,15.0,8.0,60,98000,9999,9999,300," << light.global << ','
                    << light.beam << ',' << light.diffuse << ",9999,9999,9999,9999,180,2.0\r\n";
            }
    return out.str();
}

}  // namespace terravox::test
