from PySide6.QtCore import QObject, Signal

from .parts import Part


class Old(QObject):
    session_changed = Signal()
    sessions_changed = Signal()
    replaced = Signal()
    infos_changed = Signal()
    selection_changed = Signal()
    invalid_mask_changed = Signal()
    guide_changed = Signal()
    neighbours_changed = Signal()
    ground_truth_changed = Signal()
    block_errors_changed = Signal()
    ignored_changed = Signal()
    region_changed = Signal()
    changed = Signal(object)
    proposed = Signal()
    results_changed = Signal()
    results_added = Signal()
    records_added = Signal()
    previews_changed = Signal()
    error_changed = Signal()
    history_changed = Signal()
    compared_changed = Signal()
    viewed_iteration_changed = Signal()
    parameters_changed = Signal()
    extraction_changed = Signal()

    def tell(self, part: Part) -> None:
        for one, signal in (
            (Part.FRAME, self.session_changed),
            (Part.LIST, self.sessions_changed),
            (Part.REPLACED, self.replaced),
            (Part.INFOS, self.infos_changed),
            (Part.SELECTION, self.selection_changed),
            (Part.INVALID_MASK, self.invalid_mask_changed),
            (Part.GUIDE, self.guide_changed),
            (Part.NEIGHBOURS, self.neighbours_changed),
            (Part.GROUND_TRUTH, self.ground_truth_changed),
            (Part.BLOCK_ERRORS, self.block_errors_changed),
            (Part.IGNORED, self.ignored_changed),
            (Part.REGION, self.region_changed),
            (Part.PROPOSAL, self.proposed),
            (Part.PARAMETERS, self.parameters_changed),
            (Part.EXTRACTION, self.extraction_changed),
            (Part.RESULTS, self.results_changed),
            (Part.SOME_RESULTS, self.results_added),
            (Part.RECORDS, self.records_added),
            (Part.PREVIEWS, self.previews_changed),
            (Part.EXPECTED_ERROR, self.error_changed),
            (Part.HISTORY, self.history_changed),
            (Part.COMPARED, self.compared_changed),
            (Part.ITERATION, self.viewed_iteration_changed),
        ):
            if one & part:
                signal.emit()
