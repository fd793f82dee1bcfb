#include "parts/shape/internal/min_cut.h"

#include <algorithm>
#include <boost/graph/adjacency_list.hpp>
#include <boost/graph/boykov_kolmogorov_max_flow.hpp>
#include <cmath>
#include <stdexcept>

namespace rangegrasp::parts {
namespace {

using Traits = boost::adjacency_list_traits<boost::vecS, boost::vecS, boost::directedS>;

struct Node {
  boost::default_color_type color;
  long distance;
  Traits::edge_descriptor predecessor;
};
struct Arc {
  std::int64_t capacity;
  std::int64_t residual;
  Traits::edge_descriptor reverse;
};
using Graph = boost::adjacency_list<boost::vecS, boost::vecS, boost::directedS, Node, Arc>;

// Steps of the largest capacity: finer ones than the costs are known to, and far from overflow.
constexpr double kSteps = 1e6;

}  // namespace

std::vector<bool> MinCut(std::uint32_t nodes, const std::vector<CutLink>& links,
                         std::uint32_t source, std::uint32_t sink) {
  if (source == sink || source >= nodes || sink >= nodes) {
    throw std::invalid_argument("MinCut: source and sink must be two of the nodes");
  }
  double largest = 0.0;
  for (const CutLink& link : links) largest = std::max(largest, link.capacity);
  Graph graph(nodes);
  for (const CutLink& link : links) {
    if (link.a >= nodes || link.b >= nodes) throw std::invalid_argument("MinCut: no such node");
    if (!(link.capacity > 0.0)) continue;
    const auto capacity = static_cast<std::int64_t>(std::llround(kSteps * link.capacity / largest));
    const auto there = boost::add_edge(link.a, link.b, graph).first;
    const auto back = boost::add_edge(link.b, link.a, graph).first;
    graph[there] = {capacity, 0, back};
    graph[back] = {capacity, 0, there};
  }
  boost::boykov_kolmogorov_max_flow(
      graph, boost::get(&Arc::capacity, graph), boost::get(&Arc::residual, graph),
      boost::get(&Arc::reverse, graph), boost::get(&Node::predecessor, graph),
      boost::get(&Node::color, graph), boost::get(&Node::distance, graph),
      boost::get(boost::vertex_index, graph), source, sink);
  std::vector<bool> with_source(nodes);
  for (std::uint32_t v = 0; v < nodes; ++v) {
    with_source[v] = graph[v].color == boost::black_color;
  }
  return with_source;
}

}  // namespace rangegrasp::parts
